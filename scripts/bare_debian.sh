#!/bin/sh
# Installs a wheel on a bare Debian 12, which has Python and nothing of ours, and does there what README.md shows: its
# scene is run, its lines of Python read the file. Needs root, debootstrap and a network.
set -eu
[ $# = 1 ] || { echo "usage: $0 WHEEL" >&2; exit 2; }
readme=$(dirname "$0")/../README.md
debian=$(mktemp -d)
trap 'rm -rf --one-file-system "$debian" "$debian.log"' EXIT
debootstrap --variant=minbase --include=python3-venv bookworm "$debian" > "$debian.log" ||
    { tail "$debian.log" >&2; exit 1; }
block() { sed -n "/^\`\`\`$1\$/,/^\`\`\`\$/p" "$readme" | sed '/^```/d'; }
block toml > "$debian/root/block.toml"
block python > "$debian/root/read.py"
cp "$1" "$debian/root"
# pip trusts whom this machine trusts.
mkdir -p "$debian/etc/ssl/certs"
cp /etc/ssl/certs/ca-certificates.crt "$debian/etc/ssl/certs"
started=$(date +%s)
chroot "$debian" env -i HOME=/root PATH=/usr/bin:/bin sh -eu <<'END'
cd
python3 -m venv contact
. contact/bin/activate
pip install --quiet --disable-pip-version-check --no-cache-dir contact3d_pipe-*.whl
contact3d-pipe run block.toml block.h5
python read.py > read
cat read
grep -q 'slipping panes 36' read
END
echo "installed and used on a bare Debian 12 in $(($(date +%s) - started)) s"
