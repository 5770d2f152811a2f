#!/bin/sh
# The set-up behind `make`: a virtual environment, and the system libraries that pip cannot bring.
#   tools/setup.sh venv DIR        create DIR with a Python that fits
#   tools/setup.sh libraries DIR   install missing system libraries, where that is allowed
set -eu

say() { printf '%s\n' "$*" >&2; }
die() { say "error: $*"; exit 2; }

# The first of $PYTHON, python3 and the versioned names that fits `requires-python`.
find_python() {
    for candidate in ${PYTHON:-} python3 python3.13 python3.12 python3.11 python3.14; do
        if "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 15))' 2>/dev/null; then
            echo "$candidate"
            return
        fi
    done
}

# Prints the prefix with which apt-get may be run, or fails where it may not.
apt_prefix() {
    command -v apt-get >/dev/null || return 1
    if [ "$(id -u)" = 0 ]; then echo env
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then echo "sudo env"
    else return 1; fi
}

# One package at a time: one that a release no longer has must not keep the others out.
apt_install() {
    $apt DEBIAN_FRONTEND=noninteractive apt-get update -qq >/dev/null 2>&1 || say "notice: apt-get update failed"
    for package in "$@"; do
        say "installing $package"
        $apt DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$package" \
            >/dev/null 2>&1 || say "notice: apt-get could not install $package"
    done
}

make_venv() {
    python=$(find_python)
    [ -n "$python" ] || die "no Python 3.11 to 3.14 found; install one, or name it: make PYTHON=/path/to/python3 run"
    if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
        package="python$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')-venv"
        apt=$(apt_prefix) || die "$python cannot create virtual environments; install $package (apt-get install $package)"
        apt_install "$package"
    fi
    "$python" -m venv --clear "$1" || die "$python -m venv failed; is its venv package installed?"
}

# soname and Debian package: OSMesa for the rasterise engine, the others for Open3D's shared library.
libraries="libOSMesa.so.8:libosmesa6 libGL.so.1:libgl1 libEGL.so.1:libegl1 libX11.so.6:libx11-6
libudev.so.1:libudev1 libusb-1.0.so.0:libusb-1.0-0 libidn2.so.0:libidn2-0 libstdc++.so.6:libstdc++6"

missing_packages() {
    for pair in $libraries; do
        "$1/bin/python" -c "import ctypes; ctypes.CDLL('${pair%%:*}')" 2>/dev/null || echo "${pair##*:}"
    done
}

install_libraries() {
    # shellcheck disable=SC2046  # the words are the packages
    set -- "$1" $(missing_packages "$1")
    venv=$1; shift
    [ $# -gt 0 ] || return 0
    if apt=$(apt_prefix); then apt_install "$@"; fi
    # shellcheck disable=SC2046
    set -- $(missing_packages "$venv")
    [ $# -gt 0 ] || return 0
    if [ "$*" = libosmesa6 ]; then
        say "notice: libosmesa6 is missing and could not be installed: the raycast engine is used instead"
    else
        say "notice: missing system libraries, without which Open3D may not load: apt-get install $*"
    fi
}

case "${1:-} ${2:-}" in
    "venv "?*) make_venv "$2" ;;
    "libraries "?*) install_libraries "$2" ;;
    *) die "usage: tools/setup.sh venv|libraries DIR" ;;
esac
