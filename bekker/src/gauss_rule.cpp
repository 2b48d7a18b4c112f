#include "gauss_rule.h"

#include <algorithm>
#include <boost/math/special_functions/legendre.hpp>
#include <vector>

namespace grouser::bekker {

const GaussRule& gauss_rule(int n) {
  // All rules at once: the first call pays, later ones are a look-up.
  static const std::vector<GaussRule> rules = [] {
    std::vector<GaussRule> all(97);
    for (int k = 1; k <= 96; ++k) {
      GaussRule& g = all[k];
      g.n = k;
      const std::vector<double> zeros = boost::math::legendre_p_zeros<double>(k);  // the non-negative half, ascending
      int at = 0;
      for (auto z = zeros.rbegin(); z != zeros.rend(); ++z) {
        const double p = boost::math::legendre_p_prime(k, *z), w = 1 / ((1 - *z * *z) * p * p);
        g.x[at] = 0.5 * (1 - *z);
        g.w[at] = w;
        g.x[k - 1 - at] = 0.5 * (1 + *z);
        g.w[k - 1 - at] = w;
        ++at;
      }
    }
    return all;
  }();
  return rules[std::clamp(n, 1, 96)];
}

}  // namespace grouser::bekker
