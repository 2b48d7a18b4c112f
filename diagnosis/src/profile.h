#pragma once
#include "search.h"

namespace grouser::diagnosis {

/// Ends of the 90 % profile-likelihood interval of amplitude `term` of a fitted candidate: where the objective, with this amplitude held
/// and all else refitted, is t(0.95; nu)^2 above its least, nu the noise's degrees of freedom; or the amplitude's bound. Secant in the
/// root of the rise, from the Laplace interval; about 4 refits an end. Where a refit has no answer: smaller steps and other starts; where no wheel carries
/// the load, the interval ends there.
std::array<double, 2> profile_interval(const Search& s, const Candidate& c, const Fit& f, std::size_t term);

}  // namespace grouser::diagnosis
