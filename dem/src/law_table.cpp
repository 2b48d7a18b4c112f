#include "law_table.h"

#include <cmath>

namespace grouser::dem {

template <class R>
LawTable<R> law_table(const MaterialTable& m, const LawSettings& s) {
  LawTable<R> t{};
  const int n = static_cast<int>(m.materials.size());
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) {
      const std::size_t k = m.index(a, b);
      const PairProperties& p = m.pairs[k];
      const Material &x = m.materials[static_cast<std::size_t>(a)], &y = m.materials[static_cast<std::size_t>(b)];
      double kn, kt, cn, ct;
      if (s.model == ContactModel::hertz_ch3) {
        kn = p.kn;
        kt = p.kt;
        cn = p.gamma_n;
        ct = p.gamma_t;
      } else {
        const auto plane = [](const Material& i) { return (1 - i.poisson * i.poisson) / i.young; };
        const auto shear = [&](const Material& i) {
          return 2 / i.young *
                 (s.tangential == TangentialStiffness::mindlin ? (2 - i.poisson) * (1 + i.poisson)
                                                               : (2 + i.poisson) * (1 - i.poisson));
        };
        const double E = 1 / (plane(x) + plane(y)), G = 1 / (shear(x) + shear(y));
        const double l = std::log(p.restitution), beta = l / std::hypot(l, std::acos(-1.0));
        kn = 4.0 / 3 * E;
        kt = 8 * G;
        cn = -2 * std::sqrt(5.0 / 6) * beta * std::sqrt(1.5 * kn);
        ct = -2 * std::sqrt(5.0 / 6) * beta * std::sqrt(kt);
      }
      t.kn[k] = static_cast<R>(kn);
      t.kt[k] = static_cast<R>(kt);
      t.cn[k] = static_cast<R>(cn);
      t.ct[k] = static_cast<R>(ct);
      t.mu[k] = static_cast<R>(p.friction);
      t.mur[k] = static_cast<R>(p.rolling);
      t.kc[k] = static_cast<R>(p.cohesion);
    }
  return t;
}

template LawTable<float> law_table<float>(const MaterialTable&, const LawSettings&);
template LawTable<double> law_table<double>(const MaterialTable&, const LawSettings&);

}  // namespace grouser::dem
