#!/bin/sh
# Makes a release and publishes nothing: sets its version and the date of its entry in CHANGELOG.md, makes the wheel and the
# source distribution in target/wheels and the crates in target/package, and uses each on a bare Debian 12. Then it says
# what a maintainer types to publish. Needs root, debootstrap and a network.
[ $# = 1 ] || { echo "usage: $0 VERSION" >&2; exit 2; }
version=$1
. "$(dirname "$0")/prepare.sh"
fail() { echo "error: $1" >&2; exit 2; }
[ "$(id -u)" = 0 ] && command -v debootstrap >/dev/null ||
    fail "a release is tried on a bare Debian; install debootstrap, and be root"
[ -z "$(git status --porcelain)" ] || fail "commit your changes first"
grep -qx "## $version (unreleased)" CHANGELOG.md || fail "CHANGELOG.md has no entry '## $version (unreleased)'"

old=$(sed -n 's/^version = "\(.*\)"$/\1/p' Cargo.toml | head -n 1)
sed -i "/^version = \|path = \"crates/s/\"$old\"/\"$version\"/" Cargo.toml
sed -i "s/^version: $old\$/version: $version/" CITATION.cff
sed -i "s/\"version\": \"$old\"/\"version\": \"$version\"/" codemeta.json
sed -i "s/^## $version (unreleased)\$/## $version ($(date +%F))/" CHANGELOG.md
cargo update --quiet --workspace

RELEASE=1 sh scripts/wheel.sh
rm -rf target/package
# Each crate is compiled from what is packaged; the program last.
cargo package --quiet --workspace --locked --allow-dirty
for made in target/wheels/*.whl target/wheels/*.tar.gz target/package; do
    sh scripts/bare_debian.sh "$made"
done
cat <<END
Made and tried. Look at \`git diff\`, wait for the tests, then publish:
  git commit -am "Release $version" && git tag v$version && git push origin HEAD v$version
  cargo publish --workspace --locked
  maturin upload target/wheels/*
END
