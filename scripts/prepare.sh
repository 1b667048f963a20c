# Sourced by the other scripts: a project-local Python environment with the build tools and the
# checking packages, first on PATH. Needs Rust, Python 3 and a C compiler; as root on Debian it
# fetches a missing python3-venv itself.
set -eu
cd "$(dirname "$0")/.."

environment=.venv
stamp=$environment/.prepared
wanted=$(cat scripts/build-requirements.txt python-checks/requirements.txt | cksum)

if [ "$(cat $stamp 2>/dev/null || true)" != "$wanted" ]; then
    if ! python3 -m venv --clear $environment 2>/dev/null; then
        if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
            apt-get update -qq && apt-get install -y -qq python3-venv >/dev/null
            python3 -m venv --clear $environment
        else
            echo "error: python3 -m venv does not work; install your system's python3-venv" >&2
            exit 2
        fi
    fi
    $environment/bin/python -m pip install --quiet --disable-pip-version-check \
        -r scripts/build-requirements.txt -r python-checks/requirements.txt
    echo "$wanted" > $stamp
fi

for tool in cargo cc; do
    command -v $tool >/dev/null || { echo "error: $tool is missing; install Rust and a C compiler" >&2; exit 2; }
done

# HDF5 is built from source once; its build wants a newer cmake than Debian 12 has.
PATH=$PWD/$environment/bin:$PATH
CMAKE_GENERATOR=Ninja
export PATH CMAKE_GENERATOR
