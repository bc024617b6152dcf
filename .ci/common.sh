# shellcheck shell=bash disable=SC2034
# What ./view and ./check share: package lists, installing what is missing, configuring and building. Sourced, not run.

top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
jobs=$(nproc)

# What the tree needs to build and to draw. Names of Debian 12.
build_packages=(
    g++ cmake ninja-build pkg-config
    libglm-dev libtbb-dev libfmt-dev libembree-dev libjpeg-dev libpng-dev libopenimageio-dev libzip-dev libtomlplusplus-dev
    libcli11-dev nlohmann-json3-dev libtinyobjloader-dev libnanoflann-dev libopenscenegraph-dev openscenegraph
    libglfw3-dev libimgui-dev
)
display_packages=(xvfb libgl1-mesa-dri fonts-dejavu-core)

say() { printf '%s: %s\n' "$(basename "$0")" "$*" >&2; }
die() { say "$*"; exit 1; }

# Runs a command as root: as it is, or through sudo.
as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"
    elif command -v sudo >/dev/null; then sudo "$@"
    else die "not root, and there is no sudo. Run as root: $*"
    fi
}

# quietly LOG COMMAND…: output into the log, shown when the command fails.
quietly() {
    local log=$1
    shift
    mkdir -p "$(dirname "$log")"
    "$@" >"$log" 2>&1 || { tail -n 60 "$log" >&2; die "failed: $* (all of it: $log)"; }
}

# missing_packages NAME…: those that are not installed, one a line.
missing_packages() {
    local package
    for package in "$@"; do
        [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || echo "$package"
    done
}

# The lists of packages, fetched once per run, and only when something is to be fetched.
lists_are_fresh=
refresh_lists() {
    [ -z "$lists_are_fresh" ] || return 0
    as_root apt-get update -qq || die "apt-get update failed (is there a network?)"
    lists_are_fresh=yes
}

# need_packages NAME…: installs what is missing.
need_packages() {
    if ! command -v apt-get >/dev/null; then
        say "no apt-get here; these Debian packages, or what they hold, must be installed: $*"
        return 0
    fi
    local missing
    mapfile -t missing < <(missing_packages "$@")
    [ ${#missing[@]} -gt 0 ] || return 0
    say "installing ${missing[*]}"
    refresh_lists
    quietly "$top/build/apt.log" as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"
}

# build PRESET [CMAKE ARGUMENT…]: configures and builds everything; log in build/PRESET.log. A tree that was copied or
# moved is configured anew. A new tree compiles sources together, which halves a first build; who configures by hand gets
# them one by one, which is quicker when one of them changes.
build() {
    local preset=$1 cache="$top/build/$1/CMakeCache.txt" fresh=()
    shift
    if [ -f "$cache" ] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$top" "$cache"; then fresh=(--fresh); fi
    cd "$top" || return
    if [ ! -f "$cache" ]; then
        say "building in build/$preset; the first time takes some minutes (progress: build/$preset.log)"
        set -- -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=8 "$@"
    fi
    quietly "$top/build/$preset-configure.log" cmake --preset "$preset" "${fresh[@]}" "$@"
    quietly "$top/build/$preset.log" cmake --build --preset "$preset" --parallel "$jobs"
}
