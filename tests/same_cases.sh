#!/bin/bash
# Every test case of an executable is in one entry of ctest, and in one only.
# Usage: same_cases.sh <executable> <name of a test file>...
set -uo pipefail
executable=${1:?usage: same_cases.sh <executable> <name of a test file>...}
shift
# Whatever it lists, Catch2's exit status is how much that is.
all=$("$executable" --list-test-names-only "~[.]" | sort)
entries=$(for name in "$@"; do
    listed=$("$executable" -# --list-test-names-only "[#$name]~[.]")
    [ -n "$listed" ] || echo "same_cases: $name has no test case" >&2
    echo "$listed"
done | sort)
[ -n "$all" ] || { echo "same_cases: $executable lists no test case" >&2; exit 1; }
diff <(echo "$all") <(echo "$entries") | head -n 20 || { echo "same_cases: the entries' cases (>) are not the executable's (<)" >&2; exit 1; }
echo "same_cases: $(wc -l <<< "$all") cases in $# entries"
