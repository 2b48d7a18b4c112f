#pragma once

/// Transcendental functions of a smooth wheel's stress at one vector of points: ahead of theta_m one sine-cosine pair,
/// log, two exp and two inverse roots; behind one more pair.
struct FunctionsAlone {
  int lanes;
  const char* name;
  /// Evaluates them `vectors` times, independent of each other, and returns something that depends on all.
  double (*front)(int vectors);
  double (*rear)(int vectors);
  double (*front_ten)(int vectors);  ///< the same of ten digits, as rows of a batch take them
  double (*rear_ten)(int vectors);
};
FunctionsAlone functions_alone();
