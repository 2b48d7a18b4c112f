#pragma once
// What every diagnosis (wheels, soil tests on grains, series) holds before it sees data, and when it speaks.

namespace grouser::diagnosis {

/// Prior share of "nothing is hidden"; the rest is for the accounts.
constexpr double share_none = 0.5;
/// Prior shares within that rest: one named effect, two of them, an account without a name (a drift, a response of free shape).
constexpr double share_named = 0.8, share_pair = 0.1, share_drift = 0.1;
/// Bayes factor from which something is declared and a name is given.
constexpr double decisive = 10;
/// p value of what is left over below which no account in the list explains the rows.
constexpr double gate_p = 0.01;
/// Chance from which a run that is proposed counts as one that decides.
constexpr double enough = 0.9;

}  // namespace grouser::diagnosis
