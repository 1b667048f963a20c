#!/bin/sh
# The wheel and the source distribution: built into target/wheels, the wheel installed where nothing else is, and used.
# RELEASE=1 makes the wheel for glibc 2.28 and newer, with zig as C compiler and linker.
. "$(dirname "$0")/prepare.sh"
bring wheel scripts/build-requirements.txt scripts/wheel-requirements.txt
if [ "${RELEASE:-0}" = 1 ]; then
    bring release scripts/release-requirements.txt
    features="$features --zig --compatibility manylinux_2_28 --target $(rustc --print host-tuple)"
fi
rm -rf target/wheels
# $features are words for cargo.
# shellcheck disable=SC2086
maturin build --quiet --release --locked --out target/wheels $features
maturin sdist --out target/wheels
fresh=$(mktemp -d)
trap 'rm -rf "$fresh"' EXIT
cp pipelines/newton.toml "$fresh"
started=$(date +%s)
# The installer is that of .venv, and only modules that are imported are compiled: the environment has the wheel and what
# the wheel asks for.
env -i HOME="$fresh" PATH=/usr/local/bin:/usr/bin:/bin sh -eu <<END
cd "$fresh"
python3 -m venv --without-pip environment
"$PWD/$environment/bin/python" -m pip --python environment/bin/python install --quiet --disable-pip-version-check \
    --no-cache-dir --no-compile "$PWD"/target/wheels/*.whl
environment/bin/python - <<PYTHON
import contact3d

tree = contact3d.run("newton.toml", "newton.h5")
force = tree["post/resultants/contact_force"]
assert contact3d.program().is_relative_to("$fresh"), contact3d.program()
assert tree["solve/status"].item() == "converged"
print(f"contact3d-pipe {contact3d.version()}: contact force {force.values} {force.units}")
PYTHON
END
echo "installed and used in $(($(date +%s) - started)) s: $(ls target/wheels)"
[ "${RELEASE:-0}" = 1 ] || exit 0
auditwheel show target/wheels/*.whl > target/wheels.audit
tr '\n' ' ' < target/wheels.audit | grep -q 'consistent with the following platform tag: "manylinux_2_28_' ||
    { cat target/wheels.audit >&2; exit 1; }
