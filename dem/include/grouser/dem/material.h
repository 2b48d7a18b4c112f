#pragma once
// Materials of grains and surfaces, and the variants of the contact law.
#include <string>
#include <vector>

namespace grouser::dem {

/// Elastic constants of a material.
struct Material {
  std::string name = "soil";
  double young = 7e7;     ///< Y [Pa], > 0
  double poisson = 0.35;  ///< nu [-], in [0, 0.5)
};

/// Properties of a pair of materials. The defaults are Table 4.2's for two grains, with a constant rolling coefficient.
struct PairProperties {
  double friction = 0.86;    ///< mu_c [-], >= 0
  double rolling = 0.3;      ///< mu_r: [-] when constant, [s2/m2] when rate dependent; >= 0
  double restitution = 0.4;  ///< e [-], in (0, 1]
  double cohesion = 0;       ///< k_c [J/m3], >= 0
  /// hertz-ch3 only: the constants of Table 3.2 instead of those above.
  double kn = 0, kt = 0;            ///< [N/m2]
  double gamma_n = 0, gamma_t = 0;  ///< [1/(m s)]
};

enum class ContactModel {
  hertz_ch4,  ///< Hertz-Mindlin, restitution damping, elastic-plastic spring-dashpot rolling (eqs 3.9 to 3.20)
  hertz_ch3   ///< eqs 3.1 to 3.6: cohesion, constant directional rolling torque
};
enum class RollingCoefficient {
  constant,
  rate,              ///< mu_r,eff = min(mu_r |v_t|^2, 1), v_t with the spins (eq 3.20)
  rate_without_spin  ///< the same with the velocity of the centres only
};
enum class TangentialStiffness {
  mindlin,
  printed  ///< eq 3.14 as printed, 46 % stiffer at nu = 0.35
};
enum class Cap {
  sum,     ///< spring and damping together stay below the limit (eqs 3.15, 3.16)
  springs  ///< the springs alone, damping is dropped at the limit (LIGGGHTS)
};
enum class Damping {
  implicit_,  ///< tangential and rolling dampers integrated implicitly, contact by contact
  explicit_
};

struct LawSettings {
  ContactModel model = ContactModel::hertz_ch4;
  RollingCoefficient rolling = RollingCoefficient::constant;
  TangentialStiffness tangential = TangentialStiffness::mindlin;
  Cap cap = Cap::sum;
  Damping damping = Damping::implicit_;
};

/// Symmetric table of pairs. At most 5 materials.
struct MaterialTable {
  std::vector<Material> materials = std::vector<Material>(1);
  std::vector<PairProperties> pairs =
      std::vector<PairProperties>(1);  ///< upper triangle row by row: (0,0), (0,1) .., (1,1) ..
  std::size_t index(int a, int b) const;
  PairProperties& pair(int a, int b) { return pairs[index(a, b)]; }
  const PairProperties& pair(int a, int b) const { return pairs[index(a, b)]; }
  /// Append a material; its pairs start as copies of `p`. Returns its number.
  int add(Material m, const PairProperties& p);
};

}  // namespace grouser::dem
