#pragma once
#include "search.h"

namespace grouser::diagnosis {

/// Error of the amplitude of a sensor effect that its bench check leaves, in the unit of the amplitude: four readings with the noise of
/// the series at the largest load, speed or force of its runs; a balance to 0.2 %, rolling circumference to 0.2 %, a level to 0.1 deg.
double bench_sd(const Search& s, int entry);

/// Probability that a check with error `sd` gets odds of 10 between amplitude N(x, spread) and none, the worse of the two as true:
/// z = amplitude read ~ N(x, sd^2 + spread^2) or N(0, sd^2); 400 draws each, fixed seed.
double bench_chance(double x, double spread, double sd);

}  // namespace grouser::diagnosis
