#include "soil_test_model.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "grouser/terrain/csv.h"

namespace grouser::diagnosis {
namespace {

constexpr double ln_c_lower = 16.11809565095832, ln_c_upper = 23.025850929940457;  // 1e7, 1e10 s^2/m^2

/// A stored run.
struct Stored {
  SoilTestKind kind = SoilTestKind::shear;
  RollingLaw law = RollingLaw::constant;
  Eigen::VectorXd x;
  SoilTestCurve curve;
};

class StoredFile {
 public:
  explicit StoredFile(const std::filesystem::path& file) : errors_(file), t_(CsvRecords::read(file, errors_)) {}

  std::vector<Stored> read() {
    for (const char* name : {"test", "rolling_law", "young_modulus_Pa", "friction", "rolling", "normal_stress_Pa",
                             "effect", "amount", "rise_mm"})
      if (!t_.column(name)) errors_.add(1, 1, t_.unknown_column(name));
    std::vector<std::pair<std::size_t, double>> bins;  // column and displacement
    for (std::size_t c = 0; c < t_.columns.size(); ++c) {
      const std::string& name = t_.columns[c];
      if (name.rfind(prefix, 0) != 0) continue;
      const auto at = parse_number(name.substr(prefix.size(), name.size() - prefix.size() - 3));
      if (at) bins.emplace_back(c, *at * 1e-3);
    }
    if (bins.empty()) errors_.add(1, 1, "no column 'stress_Pa_at_..._mm'; tests are stored as mean stress in steps");
    errors_.check();
    std::vector<Stored> out;
    for (const CsvRecords::Row& row : t_.rows) out.push_back(read_row(row, bins));
    errors_.check();
    return out;
  }

 private:
  const std::string& text(const CsvRecords::Row& row, const char* name) const {
    return row.cells[*t_.column(name)].text;
  }
  double number(const CsvRecords::Row& row, const char* name) {
    const CsvCell& cell = row.cells[*t_.column(name)];
    const auto x = parse_number(cell.text);
    if (!x) errors_.add(row.line, cell.column, std::string(name) + ": '" + cell.text + "' is not a finite number");
    return x.value_or(1);
  }
  Stored read_row(const CsvRecords::Row& row, const std::vector<std::pair<std::size_t, double>>& bins) {
    Stored s;
    s.kind = text(row, "test") == "plate" ? SoilTestKind::plate : SoilTestKind::shear;
    s.law = text(row, "rolling_law") == "rate" ? RollingLaw::rate : RollingLaw::constant;
    const std::string& effect = text(row, "effect");
    const bool shear = s.kind == SoilTestKind::shear;
    std::vector<double> x{std::log(number(row, "young_modulus_Pa")), std::log(number(row, "friction")),
                          std::log(number(row, "rolling"))};
    if (shear) x.push_back(std::log(number(row, "normal_stress_Pa")));
    if (s.law == RollingLaw::constant)
      for (int e = 1; e <= nested_effects; ++e) {
        const SoilTestEffect& known = soil_test_effects()[static_cast<std::size_t>(e)];
        const double a = effect == known.id  ? number(row, "amount")
                         : known.logarithmic ? std::exp(known.off)
                                             : known.off;
        x.push_back(known.logarithmic ? std::log(a) : a);
      }
    s.x = Eigen::Map<Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
    for (const auto& [column, at] : bins) {
      const CsvCell& cell = row.cells[column];
      if (cell.text.empty()) continue;
      const auto y = parse_number(cell.text);
      if (!y) {
        errors_.add(row.line, cell.column, "'" + cell.text + "' is not a finite number");
        continue;
      }
      s.curve.displacement.push_back(at);
      s.curve.stress.push_back(*y);
    }
    if (shear) s.curve.rise.assign(s.curve.displacement.size(), number(row, "rise_mm") * 1e-3);
    s.curve.line = row.line;
    return s;
  }

  static const std::string prefix;
  FileErrors errors_;
  CsvRecords t_;
};
const std::string StoredFile::prefix = "stress_Pa_at_";

/// Quadratic in all nominal inputs, one power more in rolling (two for the rate law, which covers seven decades); each
/// effect's amount alone, squared and
/// times every nominal input. An amount of zero gives the nominal terms alone.
std::vector<Emulator::Term> terms_of(RollingLaw law, SoilTestKind kind) {
  const int base = kind == SoilTestKind::shear ? 4 : 3, nested = law == RollingLaw::constant ? nested_effects : 0;
  std::vector<int> inputs;
  for (int i = 0; i < base; ++i) inputs.push_back(i);
  const auto count = static_cast<std::size_t>(base + nested);
  std::vector<Emulator::Term> out = polynomial_terms(static_cast<int>(count), inputs, 2);
  for (int power = 3; power <= (law == RollingLaw::rate && base == 4 ? 4 : 3); ++power) {
    out.emplace_back(count, 0);
    out.back()[2] = power;
  }
  for (int e = 0; e < nested; ++e) {
    const auto at = static_cast<std::size_t>(base + e);
    for (int i = -2; i < base; ++i) {
      out.emplace_back(count, 0);
      out.back()[at] = i == -2 ? 2 : 1;
      if (i >= 0) out.back()[static_cast<std::size_t>(i)] = 1;
    }
  }
  return out;
}

Emulator emulate(RollingLaw law, SoilTestKind kind, const std::vector<Stored>& all, bool rise) {
  std::vector<const Stored*> runs;
  for (const Stored& s : all)
    if (s.law == law && s.kind == kind) runs.push_back(&s);
  if (runs.empty()) throw std::invalid_argument("none");
  Eigen::MatrixXd x(static_cast<Eigen::Index>(runs.size()), runs[0]->x.size()), y;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Eigen::VectorXd out = soil_test_outputs(kind, runs[i]->curve, rise);
    if (i == 0) y.resize(x.rows(), out.size());
    x.row(static_cast<Eigen::Index>(i)) = runs[i]->x.transpose();
    y.row(static_cast<Eigen::Index>(i)) = out.transpose();
  }
  const int base = kind == SoilTestKind::shear ? 4 : 3;
  const char* names[] = {"ln Y", "ln friction", "ln rolling", "ln normal stress"};
  std::vector<Emulator::Input> inputs;
  for (int i = 0; i < x.cols(); ++i) {
    Emulator::Input in;
    if (i < base) {
      in.name = names[i], in.lower = x.col(i).minCoeff(), in.upper = x.col(i).maxCoeff();
      in.centre = 0.5 * (in.lower + in.upper), in.half = 0.5 * (in.upper - in.lower);
    } else {
      const SoilTestEffect& e = soil_test_effects()[static_cast<std::size_t>(1 + i - base)];
      in = {e.id, e.lower, e.upper, e.off, e.upper - e.off};
    }
    inputs.push_back(in);
  }
  return Emulator(inputs, terms_of(law, kind), x, y);
}

}  // namespace

const std::array<GrainCoordinate, grain_count>& grain_coordinates() {
  static const std::array<GrainCoordinate, grain_count> list{
      {{"young_modulus", "Y", "Pa"}, {"friction", "mu_c", "1"}, {"rolling_coefficient", "mu_r", "1"}}};
  return list;
}

const std::vector<SoilTestEffect>& soil_test_effects() {
  static const std::vector<SoilTestEffect> list{
      {"rolling_rate_dependence", "c", "s^2/m^2", ln_c_lower, ln_c_upper, 0, 20.3, true},
      {"cohesion", "kc", "J/m^3", 0, 6e5, 0, 3e5, false},
      {"wall_effects", "mu_wall", "1", 0, 0.6, 0, 0.3, false},
      {"grain_size", "scale", "1", std::log(0.8), std::log(1.3), 0, std::log(1.25), true}};
  return list;
}

const SoilTestWindows& soil_test_windows() {
  static const SoilTestWindows windows;
  return windows;
}

double SoilTestCoordinate::ln_prior(double x) const {
  if (!(x >= lower && x <= upper)) return -INFINITY;
  if (sd > 0) {  // cut off at the bounds
    const auto below = [&](double at) { return 0.5 * std::erfc((mean - at) / sd / std::sqrt(2.0)); };
    return -0.5 * std::pow((x - mean) / sd, 2) -
           std::log(sd * std::sqrt(2 * 3.14159265358979323846) * (below(upper) - below(lower)));
  }
  return -std::log(upper - lower);
}

Eigen::VectorXd soil_test_outputs(SoilTestKind kind, const SoilTestCurve& curve, bool rise) {
  const bool shear = kind == SoilTestKind::shear;
  const auto& windows = shear ? soil_test_windows().shear : soil_test_windows().plate;
  Eigen::VectorXd out(shear && rise ? 4 : 3);
  const auto mm = [](double x) {
    std::string s = std::to_string(x * 1e3);
    s.erase(s.find_last_not_of('0') + 1);
    return s.back() == '.' ? s + "0" : s;
  };
  for (std::size_t w = 0; w < windows.size(); ++w) {
    double sum = 0, first = INFINITY, last = -INFINITY;
    int count = 0;
    for (std::size_t i = 0; i < curve.displacement.size(); ++i) {
      const double d = curve.displacement[i];
      if (d < windows[w][0] || d > windows[w][1]) continue;
      sum += curve.stress[i], ++count;
      first = std::min(first, d), last = std::max(last, d);
    }
    const double length = windows[w][1] - windows[w][0];
    const std::string span = mm(windows[w][0]) + " to " + mm(windows[w][1]) + " mm";
    if (count < 2 || last - first < 0.4 * length)
      throw std::invalid_argument("needs at least two points over most of " + span + " of " +
                                  (shear ? "displacement" : "sinkage"));
    if (!(sum > 0)) throw std::invalid_argument("the mean stress from " + span + " is not positive");
    out[static_cast<Eigen::Index>(w)] = std::log(sum / count);
  }
  if (shear && rise) out[3] = curve.rise.back() * 1e3;
  return out;
}

SoilTestModel::SoilTestModel(const std::filesystem::path& stored, bool rise) {
  const std::vector<Stored> runs = StoredFile(stored).read();
  for (const RollingLaw law : {RollingLaw::constant, RollingLaw::rate})
    for (const SoilTestKind kind : {SoilTestKind::shear, SoilTestKind::plate}) {
      Emulator& e = emulators_[static_cast<std::size_t>(law)][static_cast<std::size_t>(kind)];
      try {
        e = emulate(law, kind, runs, rise);
      } catch (const std::invalid_argument& why) {
        throw ConfigError(stored.string(), 0, 0,
                          std::string("stored ") + (kind == SoilTestKind::shear ? "shear" : "plate") + " tests, " +
                              (law == RollingLaw::rate ? "rate" : "constant") + " law: " + why.what());
      }
    }
  for (const std::size_t k : {0U, 1U}) {
    const Emulator &a = emulators_[0][k], &b = emulators_[1][k];
    scatter_[k] = (a.dof() * a.scatter() + b.dof() * b.scatter()) / (a.dof() + b.dof());
  }
}

Eigen::VectorXd SoilTestModel::features(RollingLaw law, const SoilTestCondition& c, const Eigen::VectorXd& x) const {
  const bool shear = c.kind == SoilTestKind::shear;
  const Emulator& e = emulator(law, c.kind);
  Eigen::VectorXd in(static_cast<Eigen::Index>(e.inputs().size()));
  in.head(3) = x.head(3);
  if (law == RollingLaw::rate) in[2] += 2 * std::log(c.speed);
  Eigen::Index at = 3;
  if (shear) in[at++] = std::log(c.normal_stress);
  for (Eigen::Index i = 3; at < in.size(); ++i, ++at)
    in[at] = i < x.size() ? x[i] : soil_test_effects()[static_cast<std::size_t>(i - 2)].off;
  if (!e.inside(in)) return {};
  return e.features(in);
}

std::array<double, 2> SoilTestModel::range(RollingLaw law, int coordinate) const {
  if (law == RollingLaw::rate && coordinate == 2) return {ln_c_lower, ln_c_upper};
  const auto i = static_cast<std::size_t>(coordinate);
  const Emulator::Input &a = emulator(law, SoilTestKind::shear).inputs()[i],
                        &b = emulator(law, SoilTestKind::plate).inputs()[i];
  return {std::max(a.lower, b.lower), std::min(a.upper, b.upper)};
}

std::vector<EmulatorQuality> SoilTestModel::quality() const {
  std::vector<EmulatorQuality> out;
  for (const RollingLaw law : {RollingLaw::constant, RollingLaw::rate})
    for (const SoilTestKind kind : {SoilTestKind::shear, SoilTestKind::plate}) {
      const Emulator& e = emulator(law, kind);
      EmulatorQuality q{law == RollingLaw::rate ? "rate" : "constant", kind, e.runs(), e.runs() - e.dof(), {}, {}};
      for (int k = 0; k < e.outputs(); ++k) {
        q.scatter.push_back(std::sqrt(e.scatter()(k, k)));
        q.left_out.push_back(std::sqrt(e.left_out().col(k).squaredNorm() / e.runs()));
      }
      out.push_back(q);
    }
  return out;
}

}  // namespace grouser::diagnosis
