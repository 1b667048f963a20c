#!/bin/sh
# Installs what a release publishes on a bare Debian 12, which has nothing of ours, and does there what README.md shows:
# its scene is run, its lines of Python read the file. Takes a wheel, a source distribution (.tar.gz), or the folder of
# the packaged crates; the last two get a C compiler and this machine's Rust. Needs root, debootstrap and a network.
set -eu
[ $# = 1 ] || { echo "usage: $0 WHEEL | SOURCE | FOLDER_OF_CRATES" >&2; exit 2; }
here=$(dirname "$0")
packages=python3-venv
case $1 in
    *.whl) ;;
    *) packages=$packages,gcc,g++,libc6-dev ;;
esac
debian=$(mktemp -d)
trap 'rm -rf --one-file-system "$debian" "$debian.log"' EXIT
debootstrap --variant=minbase --include=$packages bookworm "$debian" > "$debian.log" ||
    { tail "$debian.log" >&2; exit 1; }
block() { sed -n "/^\`\`\`$1\$/,/^\`\`\`\$/p" "$here/../README.md" | sed '/^```/d'; }
block toml > "$debian/root/block.toml"
block python > "$debian/root/read.py"
case $1 in
    *.whl) ;;
    *)
        mkdir -p "$debian/rust/lib/rustlib"
        rust=$(rustc --print sysroot)
        cp -r "$rust/bin" "$debian/rust"
        cp "$rust"/lib/lib* "$debian/rust/lib"
        cp -r "$rust/lib/rustlib/$(rustc --print host-tuple)" "$debian/rust/lib/rustlib"
        ;;
esac
if [ -d "$1" ]; then
    for crate in "$1"/*.crate; do
        tar -xzf "$crate" -C "$debian/root"
    done
    cp "$here/build-requirements.txt" "$debian/root"
else
    cp "$1" "$debian/root"
fi
# pip and cargo trust whom this machine trusts.
mkdir -p "$debian/etc/ssl/certs"
cp /etc/ssl/certs/ca-certificates.crt "$debian/etc/ssl/certs"
started=$(date +%s)
# Programs that look for what lies beside them ask /proc. The mount ends with its namespace.
# shellcheck disable=SC2016
unshare --mount sh -euc 'mount --bind /proc "$0/proc"; exec chroot "$0" env -i HOME=/root PATH=/rust/bin:/usr/bin:/bin sh -eu' \
    "$debian" <<'END'
cd
python3 -m venv contact
. contact/bin/activate
install() { pip install --quiet --disable-pip-version-check --no-cache-dir "$@"; }
if ls contact3d_pipe-*.whl >/dev/null 2>&1; then
    install contact3d_pipe-*.whl
elif ls contact3d_pipe-*.tar.gz >/dev/null 2>&1; then
    install contact3d_pipe-*.tar.gz
else
    # What a registry would bring is in folders beside.
    for folder in contact3d-*/; do
        name=${folder%-*}
        [ "$name" = contact3d-pipe ] || set -- "$@" --config "patch.crates-io.$name.path='$PWD/$folder'"
    done
    install -r build-requirements.txt
    CMAKE_GENERATOR=Ninja cargo install --quiet --locked --root contact "$@" --path contact3d-pipe-*/
fi
contact3d-pipe run block.toml block.h5
python read.py > read
cat read
grep -q 'slipping panes 36' read
END
echo "$(basename "$1"): installed and used on a bare Debian 12 in $(($(date +%s) - started)) s"
