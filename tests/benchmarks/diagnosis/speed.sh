#!/usr/bin/env bash
# Processor time of `grouser diagnose` on 20 blind sets of 216 runs and more (plan full, one core).   tests/benchmarks/diagnosis/speed.sh BLIND GROUSER [TURNS]
# BLIND, GROUSER: the two programs of one build. Prints one line a set: family, set, verdict, least, median and largest of "refit and ranking" and of everything over the
# turns (default 5) in seconds; then the median over the sets and how many are over 0.5 s and 5 s. Sets are made anew in a temporary folder from a fixed seed.
set -euo pipefail
if (($# < 2)); then sed -n 2,4p "$0" >&2; exit 2; fi
blind=$(realpath "$1") grouser=$(realpath "$2") turns=${3:-5}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for family in effect:4 pair:3 null_plain:2 null_preparation:3 sensor:2 wrong_noise:2 outliers:2 outside:2; do
  "$blind" generate --plan full --n "${family#*:}" --seed "development speed" --family "${family%:*}" --oracle no \
    --out "$out/${family%:*}" --answers "$out/sealed/${family%:*}.json" 2>/dev/null
done
of() { sed -n "s/.*\"$1\": *\"\{0,1\}\([^\",]*\).*/\1/p" "$out/said/diagnosis.json" | head -1; }
for ((turn = 0; turn < turns; ++turn)); do
  for set in "$out"/*/set_*; do
    withheld=()
    [[ -f $set/withhold.txt ]] && read -ra withheld <"$set/withhold.txt"
    "$grouser" diagnose "$set/case.yaml" --data "$set/data.csv" --out "$out/said" --overwrite ${withheld:+--withhold "${withheld[@]}"} >/dev/null 2>&1
    echo "$(basename "$(dirname "$set")"),$(basename "$set"),$(of verdict),$(of rank_s),$(of total_s)"
  done
done | sort -t, -k1,3 -s | awk -F, '
  function middle(a, n,   i, j, x) {
    for (i = 2; i <= n; ++i) for (j = i; j > 1 && a[j] < a[j - 1]; --j) { x = a[j]; a[j] = a[j - 1]; a[j - 1] = x }
    return n % 2 ? a[(n + 1) / 2] : (a[n / 2] + a[n / 2 + 1]) / 2
  }
  function done() {
    if (!n) return
    m = middle(rank, n); t = middle(total, n)
    printf "%s,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f\n", name, rank[1], m, rank[n], total[1], t, total[n]
    ranks[++sets] = m; totals[sets] = t; slow += m > 0.5; late += t > 5; n = 0
  }
  BEGIN { print "family,set,verdict,rank_least_s,rank_median_s,rank_most_s,total_least_s,total_median_s,total_most_s" }
  { if ($1 "," $2 "," $3 != name) done(); name = $1 "," $2 "," $3; rank[++n] = $4 + 0; total[n] = $5 + 0 }
  END { done(); printf "# %d sets: medians %.3f s and %.3f s; over 0.5 s %d, over 5 s %d\n", sets, middle(ranks, sets), middle(totals, sets), slow, late }'
