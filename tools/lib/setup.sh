# What Sinew needs beside a Rust toolchain: a linker, HDF5 with its headers, and for runs on several ranks MPI with its
# headers and libclang. Sourced by tools/setup, run and test.
#
# Nothing is installed, and no package manager is called, when nothing is missing.
# shellcheck shell=bash

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
[[ $target = /* ]] || target=$PWD/$target
export CARGO_TARGET_DIR=$target

say() { printf '%s\n' "$@" >&2; }

# Ends with status 2: the machine lacks something that only its user can give.
stop() {
    say "$@"
    exit 2
}

# The Rust toolchain: there, and as new as Cargo.toml asks.
need_cargo() {
    local wanted found
    wanted=$(sed -n 's/^rust-version *= *"\(.*\)"/\1/p' "$root/Cargo.toml")
    # a fresh installation that the shell does not know yet
    local home=${CARGO_HOME:-${HOME:-}/.cargo}
    if ! command -v cargo >/dev/null && [ -x "$home/bin/cargo" ]; then
        PATH=$home/bin:$PATH
    fi
    command -v cargo >/dev/null ||
        stop "There is no cargo: install Rust $wanted or newer, https://www.rust-lang.org/tools/install"
    found=$(cargo --version </dev/null 2>&1) || stop "cargo does not start: $found"
    found=${found#cargo }
    found=${found%%[ -]*}
    if [ "$(printf '%s\n' "$wanted" "$found" | sort -V | head -n 1)" != "$wanted" ]; then
        if command -v rustup >/dev/null; then
            stop "cargo $found is too old, Sinew needs $wanted or newer: rustup update stable"
        fi
        stop "cargo $found is too old: install Rust $wanted or newer, https://www.rust-lang.org/tools/install"
    fi
}

# A C compiler that links: rustc calls it to link.
has_linker() { echo 'int main(void) { return 0; }' | cc -x c -o /dev/null - >/dev/null 2>&1; }

has_hdf5() {
    if [ -n "${HDF5_DIR:-}" ]; then
        [ -e "$HDF5_DIR/include/H5pubconf.h" ] || stop "HDF5_DIR=$HDF5_DIR holds no include/H5pubconf.h"
    elif [ "$(uname -s)" = Darwin ]; then
        command -v brew >/dev/null && brew --prefix --installed hdf5 >/dev/null 2>&1
    else
        pkg-config --exists hdf5 2>/dev/null || pkg-config --exists hdf5-serial 2>/dev/null ||
            [ -e /usr/include/H5pubconf.h ] # Fedora, Arch: where the build looks by itself
    fi
}

# cargo fetches crates over TLS and reads the system's certificates.
has_certificates() {
    [ -n "${SSL_CERT_FILE:-}${SSL_CERT_DIR:-}${CARGO_HTTP_CAINFO:-}" ] || [ "$(uname -s)" = Darwin ] ||
        [ -e /etc/ssl/certs/ca-certificates.crt ] || [ -e /etc/pki/tls/certs/ca-bundle.crt ] ||
        [ -e /etc/ssl/cert.pem ] || [ -e /etc/ssl/ca-bundle.pem ]
}

# MPI is optional: a launcher, a compiler wrapper that says where the headers are, and libclang, which reads them.
has_mpi() { command -v mpirun >/dev/null && command -v mpicc >/dev/null && has_libclang; }

has_libclang() {
    [ -n "${LIBCLANG_PATH:-}" ] || compgen -G '/usr/lib/llvm*/lib/libclang*.so*' >/dev/null ||
        compgen -G '/usr/lib*/libclang*.so*' >/dev/null || compgen -G '/usr/lib/*/libclang*.so*' >/dev/null ||
        { [ "$(uname -s)" = Darwin ] && xcode-select -p >/dev/null 2>&1; }
}

# MPICH beside the default MPI, which stays that.
has_mpich() { command -v mpirun.mpich >/dev/null && [ -e "$(mpicc.mpich -show 2>/dev/null | sed 's/.*-I\([^ ]*\).*/\1/')/mpi.h" ]; }

# What tests/hosts makes two hosts of.
has_hosts() { command -v ip >/dev/null && command -v unshare >/dev/null && has_sshd; }

has_sshd() { PATH=$PATH:/usr/sbin:/sbin command -v sshd >/dev/null; }

# Arguments of cargo: Sinew with MPI where there is one.
features() { has_mpi && printf '%s\n' --features mpi || true; }

# Lets root start ranks, and more of them than there are cores.
let_ranks_run() {
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
    export OMPI_MCA_hwloc_base_binding_policy=none
}

has_venv() { python3 -c 'import ensurepip, venv' 2>/dev/null; }

# The build asks pkg-config for `hdf5`. Where that is another name, or a library built for MPI stands in its place, point
# it at the serial one.
point_at_hdf5() {
    [ -z "${HDF5_DIR:-}" ] && command -v pkg-config >/dev/null && pkg-config --exists hdf5-serial || return 0
    case $(pkg-config --cflags --libs hdf5 2>/dev/null) in
        *mpi*) ;;
        *hdf5*) return 0 ;;
    esac
    mkdir -p "$target/pkgconfig"
    ln -sf "$(pkg-config --variable=pcfiledir hdf5-serial)/hdf5-serial.pc" "$target/pkgconfig/hdf5.pc"
    export PKG_CONFIG_PATH=$target/pkgconfig${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}
}

# Installs packages, or says how.
install() {
    local as=()
    local get=(apt-get install --yes --no-install-recommends "$@")
    if [ "$(id -u)" != 0 ]; then
        if ! command -v sudo >/dev/null; then
            stop "Run this as root, then try again:" "  apt-get update && ${get[*]}"
        elif sudo -n true 2>/dev/null; then
            as=(sudo -n)
        elif [ -t 0 ] && [ -t 2 ]; then
            as=(sudo)
        else
            stop "Run this, then try again:" "  sudo apt-get update && sudo ${get[*]}"
        fi
    fi
    say "installing $*"
    local apt=("${as[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300)
    # a list that cannot be refreshed may still do
    "${apt[@]}" update </dev/null >/dev/null || say "apt-get update failed; going on with the lists that are there"
    "${apt[@]}" install --yes --no-install-recommends -o Dpkg::Use-Pty=0 "$@" </dev/null >/dev/null ||
        stop "could not install $*: see above"
}

# Installs what tests/hosts needs, as root; false if it cannot. The tests start an sshd of their own: who has had none gets no
# running one.
install_hosts() (
    if has_sshd; then
        install iproute2
        return
    fi
    policy=/usr/sbin/policy-rc.d
    if [ ! -e "$policy" ]; then
        trap 'rm -f "$policy"' EXIT
        printf '#!/bin/sh\nexit 101\n' >"$policy" && chmod +x "$policy"
    fi
    install iproute2 openssh-server || return
    systemctl --quiet disable ssh.service ssh.socket 2>/dev/null || true
)

# Sees to all that a build needs; with `mpi` also to MPI, with `mpich` to a second one, with `python` to what the check of
# particle files needs, with `hosts` to tests/hosts.
need_packages() {
    local debian=() others=() wanted=" $* "
    has_linker || { debian+=(gcc libc6-dev) others+=("a C compiler"); }
    has_hdf5 || { debian+=(pkg-config libhdf5-dev) others+=("HDF5 with its headers" "pkg-config"); }
    has_certificates || { debian+=(ca-certificates) others+=("TLS certificates"); }
    if [[ $wanted = *' mpi '* ]] && ! has_mpi; then
        debian+=(openmpi-bin libopenmpi-dev libclang-dev) others+=("MPI with its headers" "libclang")
    fi
    if [[ $wanted = *' mpich '* ]] && ! has_mpich && command -v apt-get >/dev/null; then
        debian+=(mpich libmpich-dev)
    fi
    if [[ $wanted = *' python '* ]] && ! has_readers && ! has_venv; then
        debian+=(python3 python3-venv) others+=("Python 3 with venv")
    fi
    if [ "${#debian[@]}" != 0 ]; then
        if command -v apt-get >/dev/null; then
            install "${debian[@]}"
        else
            say "Sinew needs: $(printf '%s, ' "${others[@]}" | sed 's/, $//'). Install them:"
            if command -v dnf >/dev/null; then
                stop "  sudo dnf install gcc pkgconf-pkg-config hdf5-devel python3 openmpi-devel clang-devel"
            elif command -v pacman >/dev/null; then
                stop "  sudo pacman -S --needed gcc pkgconf hdf5 python openmpi clang"
            elif command -v zypper >/dev/null; then
                stop "  sudo zypper install gcc pkg-config hdf5-devel python3 openmpi4-devel clang-devel"
            elif [ "$(uname -s)" = Darwin ]; then
                stop "  xcode-select --install; brew install hdf5 pkgconf python open-mpi llvm"
            fi
            stop "  by your system's package manager, or set HDF5_DIR to an HDF5 that is elsewhere"
        fi
    fi
    # nobody else can make hosts
    if [[ $wanted = *' hosts '* ]] && ! has_hosts && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        install_hosts || say "what tests/hosts needs could not be installed"
    fi
    point_at_hdf5
}

# Python with h5py and VTK, which read particle files as ParaView does: the user's own, or an environment under target/.
venv=$target/python
wanted_readers=$root/tests/python/requirements.txt

has_readers() {
    [ -z "${have_readers:-}" ] || return 0
    if [ "$venv/ready" -nt "$wanted_readers" ] && "$venv/bin/python3" -c 'import h5py' 2>/dev/null; then
        PATH=$venv/bin:$PATH
    else
        python3 -c 'import h5py, vtk' 2>/dev/null || return 1
    fi
    have_readers=yes
}

# Puts first in PATH a python3 that has the readers. False if there is none.
need_readers() {
    has_readers && return
    install_python "$venv" 'h5py, vtk' "$wanted_readers" || return 1
    PATH=$venv/bin:$PATH
}

# The same with OVITO and PyVista, in a place of their own: $viewers/bin/python3.
viewers=$target/viewers
need_viewers() {
    local wanted=$root/tests/python/viewers.txt
    [ "$viewers/ready" -nt "$wanted" ] || install_python "$viewers" 'ovito.io, pyvista' "$wanted_readers" "$wanted"
}

# NVIDIA Warp, which Sinew is compared with, in a place of its own: $warp/bin/python3.
warp=$target/warp
need_warp() {
    local wanted=$root/tools/lib/warp/requirements.txt
    [ "$warp/ready" -nt "$wanted" ] || install_python "$warp" 'tomllib, numpy, warp' "$wanted"
}

# A Chromium without a window, and playwright-core, which drives it: $browser/node_modules. False where one of them is missing, or
# a Node.js that is new enough.
browser=$target/browser
need_browser() {
    local from=$root/tests/browser debian=()
    has_chromium || debian+=(chromium)
    command -v node >/dev/null && command -v npm >/dev/null || debian+=(nodejs npm)
    if [ "${#debian[@]}" != 0 ]; then
        command -v apt-get >/dev/null || return 1
        (install "${debian[@]}") || return 1
    fi
    [ "$(node --version | sed 's/^v\([0-9]*\).*/\1/')" -ge 18 ] || return 1
    [ "$browser/ready" -nt "$from/package-lock.json" ] && return
    say "installing playwright-core into $browser"
    mkdir -p "$browser" && cp "$from/package.json" "$from/package-lock.json" "$browser/" &&
        (cd "$browser" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error </dev/null >&2) &&
        touch "$browser/ready"
}

has_chromium() {
    [ -n "${CHROMIUM:-}" ] || command -v chromium >/dev/null || command -v chromium-browser >/dev/null || command -v google-chrome >/dev/null
}

# install_python VENV MODULES REQUIREMENTS...: a Python with packages, in which these modules can be imported.
install_python() {
    local venv=$1 modules=$2
    shift 2
    say "installing Python packages into $venv"
    python3 -m venv --clear "$venv" >&2 &&
        "$venv/bin/python3" -m pip install --quiet --no-input --disable-pip-version-check --retries 2 --timeout 30 \
            --only-binary :all: "${@/#/--requirement=}" </dev/null >&2 &&
        "$venv/bin/python3" -c "import $modules" >&2 &&
        touch "$venv/ready"
}

# What tests under emulation of AArch64 need: a linker, QEMU, the standard library, and HDF5 of that architecture in a folder. False if
# they cannot be had.
aarch64=$target/aarch64-system

need_aarch64() {
    command -v rustup >/dev/null && command -v apt-get >/dev/null && [ "$(uname -m)" = x86_64 ] || return 1
    rustup target add aarch64-unknown-linux-gnu >/dev/null 2>&1 || return 1
    if ! { command -v aarch64-linux-gnu-gcc && command -v qemu-aarch64; } >/dev/null; then
        (install gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user) || return 1
    fi
    [ -e "$aarch64/ready" ] || fetch_aarch64 || return 1
}

# Fetches HDF5 and all that it needs as packages, and unpacks them. The system's own lists and packages stay as they are.
fetch_aarch64() {
    rm -rf "$aarch64"
    mkdir -p "$aarch64"/state/lists/partial "$aarch64"/cache/archives/partial "$aarch64"/system "$aarch64"/hdf5/lib
    : >"$aarch64/status"
    local apt=(apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o "Dir::State=$aarch64/state"
        -o "Dir::State::status=$aarch64/status" -o "Dir::Cache=$aarch64/cache" -o Debug::NoLocking=true)
    [ "$(id -u)" != 0 ] || apt+=(-o APT::Sandbox::User=root)
    "${apt[@]}" update >/dev/null || return 1
    "${apt[@]}" --yes --no-install-recommends --download-only install libhdf5-dev >/dev/null || return 1
    local package name
    for package in "$aarch64"/cache/archives/*.deb; do dpkg -x "$package" "$aarch64/system" || return 1; done
    ln -s "$aarch64/system/usr/include/hdf5/serial" "$aarch64/hdf5/include"
    for name in hdf5 hdf5_hl; do
        ln -s "$(readlink -f "$aarch64/system/usr/lib/aarch64-linux-gnu/lib${name/hdf5/hdf5_serial}.so")" "$aarch64/hdf5/lib/lib$name.so"
    done
    # the build asks a library that it can load for its version: that of this machine, under a name that no linker takes
    ln -s "$(ldconfig -p | sed -n 's/.*libhdf5_serial\.so\.[0-9]* .*=> //p' | head -n 1)" "$aarch64/hdf5/lib/libhdf5.dylib"
    touch "$aarch64/ready"
}
