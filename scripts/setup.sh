# Shared by the scripts beside it (sourced, not run): finds or installs what a fresh machine needs.
# Nothing is installed that is already there; without the rights to install, says what is missing.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# missing TEST PACKAGE...: prints the Debian packages unless the shell command TEST succeeds.
missing() {
    eval "$1" >/dev/null 2>&1 || echo "${@:2}"
}

# want_packages TEST PACKAGE...: installs the packages unless TEST succeeds; says so and fails where it may not.
want_packages() {
    local sudo="" packages
    packages=$(missing "$@")
    if [ -z "$packages" ]; then
        return
    fi
    if [ "$(id -u)" -ne 0 ]; then
        sudo="sudo -n"
    fi
    if command -v apt-get >/dev/null && $sudo true 2>/dev/null; then
        echo "installing: $packages" >&2
        # Once for all that a script needs.
        if [ -z "${package_lists_updated:-}" ]; then
            $sudo apt-get update -qq >&2 || true
            package_lists_updated=yes
        fi
        # shellcheck disable=SC2086 # several words
        if DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq --no-install-recommends $packages >&2; then
            return
        fi
    fi
    echo "slipmap needs these packages (names as on Debian and Ubuntu), please install them: $packages" >&2
    return 1
}

# need_packages TEST PACKAGE...: as want_packages, and ends the script where they are not to be had.
need_packages() {
    want_packages "$@" || exit 2
}

build_tools=("command -v cc && command -v pkg-config && pkg-config --exists hdf5" build-essential pkg-config libhdf5-dev)
need_build_tools() {
    if ! command -v cargo >/dev/null && [ -f "$HOME/.cargo/env" ]; then
        . "$HOME/.cargo/env"
    fi
    if ! command -v cargo >/dev/null; then
        echo "slipmap needs Rust 1.92 or newer: https://rustup.rs" >&2
        exit 2
    fi
    need_packages "${build_tools[@]}"
}

# build_web: the page of `slipmap explore` as WebAssembly, in gzip and base64, which builds of slipmap from here on put into the
# program; where the compiler lacks WebAssembly they leave it out. The flags of other builds are not for it.
build_web() {
    local triple=wasm32-unknown-unknown library
    library=$(rustc --print target-libdir --target "$triple" 2>/dev/null) || true
    if [ ! -d "$library" ] && ! { command -v rustup && rustup --quiet target add "$triple"; } >&2; then
        echo "left out: the page as a file of its own, for which the compiler needs \`rustup target add $triple\`" >&2
        return
    fi
    env -u RUSTFLAGS -u RUSTC_WORKSPACE_WRAPPER -u SLIPMAP_WASM cargo build --quiet --locked --manifest-path "$root/Cargo.toml" \
        --package slipmap-web --profile web --target "$triple"
    SLIPMAP_WASM="$(cd "${CARGO_TARGET_DIR:-$root/target}" && pwd)/$triple/web/slipmap_web.txt"
    export SLIPMAP_WASM
    gzip -9n <"${SLIPMAP_WASM%.txt}.wasm" | base64 | tr -d '\n' >"$SLIPMAP_WASM.new"
    # The same bytes are no reason to build anew.
    if cmp -s "$SLIPMAP_WASM.new" "$SLIPMAP_WASM"; then
        rm "$SLIPMAP_WASM.new"
    else
        mv "$SLIPMAP_WASM.new" "$SLIPMAP_WASM"
    fi
}

# make_environment FOLDER REQUIREMENTS: a virtual environment with these packages; rebuilt if they change.
# Python compiles what is imported when it is; to compile all files here would take as long as to install them.
venv=("python3 -m venv --help && python3 -m ensurepip --version" python3-venv python3-pip)
make_environment() {
    need_packages "${venv[@]}"
    if ! cmp -s "$2" "$1/requirements.txt"; then
        mkdir -p "$(dirname "$1")"
        python3 -m venv --clear "$1"
        "$1/bin/pip" install -q --disable-pip-version-check --no-compile -r "$2"
        cp "$2" "$1/requirements.txt"
    fi
}

# The Python programs that read maps as users do, and what tests the Python package, in a folder of their own
# that git ignores.
readers=("command -v ncdump && command -v h5dump" netcdf-bin hdf5-tools)
need_python() {
    need_packages "${readers[@]}"
    make_environment "$root/target/venv" "$root/scripts/requirements.txt"
    python="$root/target/venv/bin/python"
}

# All that tests run: the crates, their tests, and the compiled part of the Python package, for any Python. One build, since
# cargo compiles what the parts share anew for each set of parts that is asked for.
build_for_tests() {
    build_web
    (cd "$root" && PYO3_NO_PYTHON=1 PYO3_BUILD_EXTENSION_MODULE=1 cargo build --locked --workspace --all-targets)
}

# pdflatex with what the LaTeX of reports uses (siunitx is in texlive-science): 120 MB to fetch, a minute or
# two.
latex=("command -v pdflatex && kpsewhich siunitx.sty && kpsewhich booktabs.sty"
    texlive-latex-base texlive-latex-recommended texlive-science)
# A browser, and a reader of the files that it prints, for tests of the pages.
chromium=("command -v chromium && command -v pdftotext" chromium poppler-utils)
# A file server to be killed during a run.
mounts=("command -v bindfs" bindfs fuse3)
