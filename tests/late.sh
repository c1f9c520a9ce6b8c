# Sourced by tests/run.sh and tests/editors.sh; .ci/run says when it began. POSIX sh.

ci_began=${QUADRATURA_BEGAN:-$(date +%s)}

# late MINUTES: in CI, whether so many have passed. On a slow machine, the whole would not end within the limit of CI, so that what
# repeats other tests under other conditions is left out there, and named at the end.
late() {
    [ "${CI:-}" = true ] && [ $(($(date +%s) - ci_began)) -gt $((60 * $1)) ]
}
