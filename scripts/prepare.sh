# Sourced by the other scripts: a project-local Python environment first on PATH, and in $features what cargo is told
# about HDF5: built from source, or the system's with HDF5=system. Needs Rust, Python 3 and a C compiler; as root on
# Debian it fetches a missing python3-venv itself.
set -eu
cd "$(dirname "$0")/.."

environment=.venv

# Brings packages into the environment: a name for the stamp, then files of requirements.
bring() {
    stamp=$environment/.$1
    shift
    wanted=$(cat "$@" | cksum)
    [ "$(cat "$stamp" 2>/dev/null || true)" != "$wanted" ] || return 0
    if ! [ -x $environment/bin/python ] && ! python3 -m venv --clear $environment 2>/dev/null; then
        if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
            apt-get update -qq && apt-get install -y -qq python3-venv >/dev/null
            python3 -m venv --clear $environment
        else
            echo "error: python3 -m venv does not work; install your system's python3-venv" >&2
            exit 2
        fi
    fi
    $environment/bin/python -m pip install --quiet --disable-pip-version-check $(printf ' -r %s' "$@")
    echo "$wanted" > "$stamp"
}

# Whether there is an HDF5 that serves: 1.10.2 or newer, serial, with deflate, and found when a program starts.
system_hdf5_serves() {
    flags=$(pkg-config --cflags --libs hdf5 2>/dev/null) || return 1
    probe=$(mktemp -d)
    cat > "$probe/probe.c" <<'END'
#include <hdf5.h>
#if defined(H5_HAVE_PARALLEL) || !H5_VERSION_GE(1, 10, 2)
#error "too old, or parallel"
#endif
int main(void) { return H5Zfilter_avail(H5Z_FILTER_DEFLATE) > 0 ? 0 : 1; }
END
    serves=1
    # The flags are several words.
    # shellcheck disable=SC2086
    if cc "$probe/probe.c" $flags -o "$probe/probe" 2>/dev/null && "$probe/probe"; then
        serves=0
    fi
    rm -rf "$probe"
    return $serves
}

for tool in cargo cc; do
    command -v $tool >/dev/null || { echo "error: $tool is missing; install Rust and a C compiler" >&2; exit 2; }
done

bring build scripts/build-requirements.txt

case ${HDF5:-bundled} in
    bundled)
        features=
        ;;
    system)
        system_hdf5_serves || {
            echo "error: no usable HDF5 (pkg-config hdf5: 1.10.2 or newer, serial, with deflate); install it, or leave HDF5 unset" >&2
            exit 2
        }
        features=--no-default-features
        ;;
    *)
        echo "error: HDF5=$HDF5; it may be bundled or system" >&2
        exit 2
        ;;
esac

# HDF5 is built from source once; its build wants a newer cmake than Debian 12 has.
PATH=$PWD/$environment/bin:$PATH
CMAKE_GENERATOR=Ninja
export PATH CMAKE_GENERATOR

# What `--version` says; nothing outside of a clone.
CONTACT3D_COMMIT=$(git rev-parse --short=12 HEAD 2>/dev/null || true)
[ -z "$CONTACT3D_COMMIT" ] || export CONTACT3D_COMMIT
