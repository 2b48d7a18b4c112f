#include "bekker_cases.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "grouser/terrain/types.h"

namespace grouser::app {

namespace {

struct Spec {
  CaseColumn column;
  const char* name;
  Range range;
};
using C = CaseColumn;
const Range nowhere_below_0 = Range::non_negative(), above_0 = Range::positive(), any = Range::any();
const Range share = Range::between(0, 1);

const std::array specs{
    Spec{C::c_Pa, "c_Pa", nowhere_below_0},
    Spec{C::phi_rad, "phi_rad", {0, pi / 2, false, true}},
    Spec{C::n, "n", Range::between(0.05, 4)},
    Spec{C::K_m, "K_m", above_0},
    Spec{C::kc, "kc", any},
    Spec{C::kphi, "kphi", any},
    Spec{C::radius_m, "radius_m", above_0},
    Spec{C::width_m, "width_m", above_0},
    Spec{C::slip, "slip", Range::between(-1, 1)},
    Spec{C::beta_rad, "beta_rad", {-pi / 2, pi / 2, true, true}},
    Spec{C::theta_f_rad, "theta_f_rad", {0, pi, true, true}},
    Spec{C::theta_m_rad, "theta_m_rad", {-pi, pi, true, true}},
    Spec{C::theta_r_rad, "theta_r_rad", {-pi, pi, true, true}},
    Spec{C::load_N, "load_N", above_0},
    Spec{C::a0, "a0", share},
    Spec{C::a1, "a1", share},
    Spec{C::b0, "b0", share},
    Spec{C::b1, "b1", share},
    Spec{C::torque_Nm, "torque_Nm", any},
    Spec{C::shear_type, "shear_type", any},
    Spec{C::Kw_m, "Kw_m", above_0},
    Spec{C::Kr, "Kr", {0, 1, true, false}},
    Spec{C::lug_height_m, "lug_height_m", nowhere_below_0},
    Spec{C::lug_ratio, "lug_ratio", share},
    Spec{C::ko, "ko", nowhere_below_0},
    Spec{C::Au, "Au", nowhere_below_0},
    Spec{C::zu_m, "zu_m", nowhere_below_0},
    Spec{C::lateral, "lateral", any},
};
const Spec& spec_of(C c) { return specs[static_cast<std::size_t>(c)]; }

std::string allowed(const Range& r) {
  std::string text;
  if (std::isfinite(r.lower)) text = fmt::format("{} {:.6g}", r.lower_open ? "more than" : "at least", r.lower);
  if (std::isfinite(r.upper))
    text += fmt::format("{}{} {:.6g}", text.empty() ? "" : " and ", r.upper_open ? "less than" : "at most", r.upper);
  return text;
}

const std::filesystem::path& existing(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file))
    throw ConfigError(file.string(), 0, 0, "this is a folder; a CSV file is wanted");
  if (!std::filesystem::is_regular_file(file)) throw ConfigError(file.string(), 0, 0, "no such file; check the path");
  return file;
}

std::string short_text(const std::string& s) { return s.size() > 40 ? s.substr(0, 40) + "..." : s; }

}  // namespace

const std::vector<C> force_columns{C::c_Pa,        C::phi_rad,  C::n,       C::K_m,         C::kc,
                                   C::kphi,        C::radius_m, C::width_m, C::theta_f_rad, C::theta_m_rad,
                                   C::theta_r_rad, C::slip,     C::beta_rad};
const std::vector<C> solve_columns{C::c_Pa,    C::phi_rad, C::n,  C::K_m, C::kc, C::kphi, C::radius_m,
                                   C::width_m, C::load_N,  C::a0, C::a1,  C::b0, C::b1,   C::beta_rad};
const std::vector<C> optional_columns{C::shear_type, C::Kw_m, C::Kr,   C::lug_height_m, C::lug_ratio,
                                      C::ko,         C::Au,   C::zu_m, C::lateral};

std::string name_of(CaseColumn c) { return spec_of(c).name; }

CaseFile::CaseFile(const std::filesystem::path& file, std::vector<CaseColumn> required,
                   std::vector<CaseColumn> optional, const std::vector<std::string>& written)
    : csv_(CsvFile::read(existing(file))), place_(specs.size(), -1) {
  FileErrors errors(file);
  std::vector<std::string> wanted, names;
  for (const C c : required) wanted.push_back(name_of(c));
  if (csv_.rows().empty())
    errors.fail(0, 0,
                fmt::format("the file is empty; a header line with the columns {} is wanted", fmt::join(wanted, ",")));
  std::vector<CsvCell> head;
  const int line = csv_.rows()[0].line;
  if (!CsvFile::split(header(), head)) errors.add(line, head.back().column, "the quoted cell is not closed");
  columns_ = head.size();
  for (const CsvCell& h : head) {
    const auto same = std::find(names.begin(), names.end(), h.text);
    if (same != names.end())
      errors.add(line, h.column,
                 fmt::format("column '{}' is there twice (columns {} and {}); remove or rename one", h.text,
                             same - names.begin() + 1, names.size() + 1));
    if (std::find(written.begin(), written.end(), h.text) != written.end())
      errors.add(line, h.column,
                 fmt::format("column '{}' is one that this command writes; remove or rename it", h.text));
    names.push_back(h.text);
  }
  const auto find = [&](C c) {
    const auto at = std::find(names.begin(), names.end(), name_of(c));
    if (at == names.end()) return false;
    place_[static_cast<std::size_t>(c)] = static_cast<int>(at - names.begin());
    return true;
  };
  std::vector<C> missing, absent;
  for (const C c : required)
    if (!find(c)) missing.push_back(c);
  for (const C c : optional)
    if (!find(c)) absent.push_back(c);
  std::vector<std::string> others, absent_names;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::find(place_.begin(), place_.end(), static_cast<int>(i)) == place_.end()) others.push_back(names[i]);
  for (const C c : absent) absent_names.push_back(name_of(c));
  for (const C c : missing) {
    auto near = did_you_mean(name_of(c), others);
    const std::string stem = name_of(c).substr(0, name_of(c).rfind('_') + 1);
    const auto same = std::find_if(others.begin(), others.end(), [&](const std::string& o) {
      return !stem.empty() && o.starts_with(stem) && o.find('_', stem.size()) == std::string::npos;
    });
    const bool other_unit = !near && same != others.end();
    if (other_unit) near = *same;
    const auto at =
        near ? head[static_cast<std::size_t>(std::find(names.begin(), names.end(), *near) - names.begin())].column : 1;
    errors.add(line, at,
               fmt::format("missing column '{}'{}", name_of(c),
                           other_unit ? "; '" + *near + "' is in another unit: convert it and rename the column"
                           : near     ? "; did you mean it by '" + *near + "'?"
                                      : "; this command needs " + fmt::format("{}", fmt::join(wanted, ","))));
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool other = std::find(place_.begin(), place_.end(), static_cast<int>(i)) == place_.end();
    if (const auto near = other && names[i].size() > 3 ? did_you_mean(names[i], absent_names) : std::nullopt)
      errors.add(line, head[i].column,
                 fmt::format("unknown column '{}'; did you mean '{}'? A column of your own needs a name less like it",
                             names[i], *near));
  }
  errors.check();
  if (size() == 0) errors.fail(line, 1, "there are no rows below the header");
}

CaseFile::Row::Row(const CaseFile& file, std::size_t row, FileErrors& errors)
    : file_(file), errors_(errors), line_(file.line(row)), complete_(true) {
  if (!CsvFile::split(file.text(row), cells_)) {
    complete_ = false;
    errors_.add(line_, cells_.back().column, "the quoted cell is not closed");
  } else if (cells_.size() != file.columns_) {
    complete_ = false;
    const bool few = cells_.size() < file.columns_;
    errors_.add(line_, few ? static_cast<int>(file.text(row).size()) : cells_[file.columns_].column,
                fmt::format("{} cell{} where the header has {}; separate cells by commas", cells_.size(),
                            cells_.size() == 1 ? "" : "s", file.columns_));
  }
}

const CsvCell* CaseFile::Row::cell(CaseColumn c) const {
  const int at = file_.place_[static_cast<std::size_t>(c)];
  return at < 0 || !complete_ ? nullptr : &cells_[static_cast<std::size_t>(at)];
}

bool CaseFile::Row::has(CaseColumn c) const {
  const CsvCell* x = cell(c);
  return x && !x->text.empty();
}

void CaseFile::Row::error(CaseColumn c, const std::string& message) {
  const CsvCell* x = cell(c);
  errors_.add(line_, x ? x->column : 1, fmt::format("{}: {}", name_of(c), message));
}

double CaseFile::Row::number(CaseColumn c) {
  const CsvCell* x = cell(c);
  if (!x) return 0;
  const Range& range = spec_of(c).range;
  const std::string limits = allowed(range);
  const std::string want = limits.empty() ? "" : "; allowed is " + limits;
  const auto value = parse_number(x->text);
  if (x->text.empty())
    error(c, "the cell is empty; a number is wanted" + want);
  else if (!value)
    error(c, fmt::format("'{}' is not a finite number{}", short_text(x->text), want));
  else if (!range.contains(*value))
    error(c, fmt::format("'{}' is out of range{}", short_text(x->text), want));
  return value.value_or(0);
}

double CaseFile::Row::number_or(CaseColumn c, double fallback) { return has(c) ? number(c) : fallback; }

std::size_t CaseFile::Row::choice_or(CaseColumn c, const std::vector<std::string>& choices, std::size_t fallback) {
  if (!has(c)) return fallback;
  const std::string& text = cell(c)->text;
  const auto at = std::find(choices.begin(), choices.end(), text);
  if (at != choices.end()) return static_cast<std::size_t>(at - choices.begin());
  const auto near = did_you_mean(text, choices);
  error(c, fmt::format("'{}' is not one of {}{}", short_text(text), fmt::join(choices, ", "),
                       near ? "; did you mean '" + *near + "'?" : ""));
  return fallback;
}

namespace {

bekker::WheelSize wheel_of(CaseFile::Row& row) {
  const bekker::WheelSize w{row.number(C::radius_m), row.number(C::width_m), row.number_or(C::lug_height_m, 0),
                            row.number_or(C::lug_ratio, 0)};
  if (w.lug_height > 0 && row.complete() && !(w.lug_ratio > 0))
    row.error(row.has(C::lug_ratio) ? C::lug_ratio : C::lug_height_m,
              "a wheel with lugs needs lug_ratio, the share of their tips in the surface: more than 0 and at most 1");
  return w;
}

bekker::SoilLaw soil_of(CaseFile::Row& row, double width) {
  bekker::SoilLaw s;
  s.n = row.number(C::n);
  const double kc = row.number(C::kc), kphi = row.number(C::kphi);
  s.modulus = kc / width + kphi;
  if (row.complete() && width > 0 && !(s.modulus > 0 && std::isfinite(s.modulus)))
    row.error(C::kc, fmt::format("the modulus kc/width_m + kphi = {:.6g} is not positive", s.modulus));
  s.shear.cohesion = row.number(C::c_Pa);
  s.shear.friction_angle = row.number(C::phi_rad);
  s.tan_phi = std::tan(s.shear.friction_angle);
  const std::size_t type = row.choice_or(C::shear_type, {"A", "B", "C"}, 0);
  s.shear.type = static_cast<ShearLaw::Type>(type);
  // A cell that the row's shear type does not use may stay empty, but not hold nonsense.
  const auto displacement = [&](C c, bool used, const char* why) {
    if (used && row.complete() && !row.has(c)) row.error(c, why);
    return row.number_or(c, 0);
  };
  s.shear.K = displacement(C::K_m, type == 0, "a number is wanted for shear type A");
  s.shear.Kw = displacement(C::Kw_m, type != 0, "a number is wanted for shear types B and C");
  s.shear.Kr = displacement(C::Kr, type == 2, "a number is wanted for shear type C");
  s.ko = row.number_or(C::ko, 0);
  s.Au = row.number_or(C::Au, 0);
  s.lateral =
      row.choice_or(C::lateral, {"iso", "aniso"}, 0) == 1 ? bekker::Lateral::anisotropic : bekker::Lateral::isotropic;
  return s;
}

double unloading_sinkage(CaseFile::Row& row, const bekker::SoilLaw& s) {
  const double zu = row.number_or(C::zu_m, 0);
  if (zu > 0 && s.ko + s.Au * zu <= 0)
    row.error(C::zu_m, "a soil that was loaded before needs an unloading slope: give ko or Au more than 0");
  return zu;
}

}  // namespace

bekker::ForceCase force_case(CaseFile::Row& row) {
  bekker::ForceCase c;
  c.wheel = wheel_of(row);
  c.soil = soil_of(row, c.wheel.width);
  c.arc = {row.number(C::theta_f_rad), row.number(C::theta_m_rad), row.number(C::theta_r_rad)};
  if (c.arc.theta_f > 0 && c.arc.theta_m >= c.arc.theta_f)
    row.error(C::theta_m_rad, "must be less than theta_f_rad: the front branch would carry nothing");
  if (row.complete() && c.wheel.lug_height > 0 && c.arc.theta_f > pi / 2)
    row.error(C::theta_f_rad,
              "with lugs at most pi/2: with the hub below the surface the tread would meet the soil before the tips");
  if (row.complete() && c.arc.theta_m <= -c.arc.theta_f)
    row.error(C::theta_m_rad, "must be more than -theta_f_rad: the wheel is out of the soil there");
  if (row.complete() && c.arc.theta_f - c.arc.theta_r > pi)
    row.error(C::theta_r_rad,
              fmt::format("theta_f_rad - theta_r_rad = {:.6g} is more than half a turn; at most pi is allowed",
                          c.arc.theta_f - c.arc.theta_r));
  if (row.complete() && c.arc.theta_r > c.arc.theta_m) row.error(C::theta_r_rad, "must be at most theta_m_rad");
  c.slip = row.number(C::slip);
  c.slip_angle = row.number(C::beta_rad);
  c.unloading_sinkage = unloading_sinkage(row, c.soil);
  return c;
}

bekker::LoadCase load_case(CaseFile::Row& row, bool free_slip) {
  bekker::LoadCase c;
  c.wheel = wheel_of(row);
  c.soil = soil_of(row, c.wheel.width);
  c.soil.angles = {row.number(C::a0), row.number(C::a1), row.number(C::b0), row.number(C::b1)};
  c.load = row.number(C::load_N);
  if (!free_slip) c.slip = row.number(C::slip);
  const double rear = c.soil.angles.b0 + c.soil.angles.b1 * std::abs(c.slip);  // free slip: at slip 0
  if (row.complete() && rear > 1)
    row.error(C::b1, fmt::format("b0 + b1 |slip| = {:.6g} puts theta_r beyond -theta_f; at most 1 is allowed", rear));
  c.slip_angle = row.number(C::beta_rad);
  c.unloading_sinkage = unloading_sinkage(row, c.soil);
  return c;
}

}  // namespace grouser::app
