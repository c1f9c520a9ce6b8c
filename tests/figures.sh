#!/bin/sh
# The figures that the house is measured by: sh tests/figures.sh [--verbose]
#
# Lines by room, circles of files, drawing functions with the whole editor, words, public items, helpers for
# pictures, tests that return early. tests/figures/count.py defines each beside the code that counts it.
set -eu
cd "$(dirname "$0")/.."
exec python3 tests/figures/count.py "$@"
