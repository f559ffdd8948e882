#!/bin/sh
# Runs kinetostat and public alternatives on the same loaded machine, one after the other, and prints a Markdown table.
# Needs cargo, Python 3.11 or later with venv, and network for the first run. Everything stays in target/peers.
set -eu
cd "$(dirname "$0")/../.."
work="${CARGO_TARGET_DIR:-target}/peers"
mkdir -p "$work"
work="$(cd "$work" && pwd)"
python="$work/venv/bin/python"

[ -x "$python" ] || "${PYTHON:-python3}" -m venv "$work/venv"
"$python" -m pip install --quiet --disable-pip-version-check --requirement benches/peers/requirements.txt

# OpenSeesPy's library needs BLAS and LAPACK, which its package does not bring. Without them on the system, Debian's are
# unpacked beside the environment; nothing is installed.
libraries=""
if ! "$python" -c "import ctypes; ctypes.CDLL('libblas.so.3'); ctypes.CDLL('liblapack.so.3')" 2>/dev/null; then
    if command -v apt-get >/dev/null && command -v dpkg >/dev/null; then
        if [ ! -d "$work/debian" ]; then
            mkdir -p "$work/packages"
            (cd "$work/packages" && apt-get download libblas3 liblapack3 libgfortran5 libquadmath0 2>/dev/null) || true
            for package in "$work"/packages/*.deb; do [ ! -f "$package" ] || dpkg -x "$package" "$work/debian"; done
        fi
        if [ -d "$work/debian" ]; then
            libraries="$(find "$work/debian" -name '*.so.*' -exec dirname {} \; | sort -u | paste -sd:)"
        fi
    fi
fi

cargo bench --quiet --bench peers >"$work/ours.json"
export PYTHONDONTWRITEBYTECODE=1 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1
for peer in numpy_vjm pynite_frame opensees_frame exudyn_springs; do
    rm -f "$work/$peer.json"
    LD_LIBRARY_PATH="$libraries${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" \
        "$python" "benches/peers/$peer.py" "$work/ours.json" "$work/$peer.json" >"$work/$peer.log" 2>&1 ||
        echo "$peer did not run: $(tail -n 1 "$work/$peer.log")" >&2
done
"$python" benches/peers/table.py "$work"
