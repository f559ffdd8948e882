#!/usr/bin/env bash
# Makes the engine of the pages anew: src/page/assets/engine.wasm.br.
# Needs rustup's target wasm32-unknown-unknown, Node and npm (for binaryen's wasm-opt).
#   web/build.sh [FOLDER]     writes into FOLDER instead of the assets
set -euo pipefail
cd "$(dirname "$0")"
out=$(realpath "${1:-../src/page/assets}")
rustup target list --installed | grep -q wasm32-unknown-unknown || rustup target add wasm32-unknown-unknown
# Paths of this machine do not get into the file.
export CARGO_ENCODED_RUSTFLAGS
CARGO_ENCODED_RUSTFLAGS=$(printf '%s\x1f' \
    --cfg 'getrandom_backend="unsupported"' -C target-feature=+simd128 -C link-arg=-zstack-size=4194304 \
    --remap-path-prefix="$(realpath ..)=kinetostat" --remap-path-prefix="${CARGO_HOME:-$HOME/.cargo}=cargo")
CARGO_ENCODED_RUSTFLAGS=${CARGO_ENCODED_RUSTFLAGS%$'\x1f'}
cargo build --quiet --release --locked
npm ci --silent --no-audit --no-fund
made="${CARGO_TARGET_DIR:-target}/wasm32-unknown-unknown/release/kinetostat_web.wasm"
small=$(mktemp)
trap 'rm -f "$small"' EXIT
node_modules/.bin/wasm-opt "$made" -Oz --converge --strip-debug --strip-producers --strip-target-features --enable-simd \
    --enable-bulk-memory --enable-nontrapping-float-to-int --enable-sign-ext --enable-mutable-globals --enable-multivalue \
    --enable-reference-types -o "$small"
node compress.mjs < "$small" > "$out/engine.wasm.br"
size=$(stat -c %s "$out/engine.wasm.br")
echo "engine.wasm.br: $size bytes"
if [ "$size" -ge 705000 ]; then
    echo "the engine must stay below 705000 bytes" >&2
    exit 1
fi
