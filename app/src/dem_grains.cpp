#include "dem_grains.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "grouser/terrain/csv_stream.h"
#include "grouser/terrain/state_stream.h"
#include "whole_file.h"

namespace grouser::app {

namespace {

const std::vector<std::string> wanted{"x", "y", "z", "radius", "density"};
const std::vector<std::string> moving{"vx", "vy", "vz", "wx", "wy", "wz"};

}  // namespace

NumberTable read_numbers(const std::filesystem::path& file, const std::vector<std::string>& needed,
                         const std::vector<std::string>& optional, FileErrors& errors) {
  const CsvRecords csv = CsvRecords::read(file, errors);
  std::vector<std::string> known = needed;
  known.insert(known.end(), optional.begin(), optional.end());
  std::vector<std::optional<std::size_t>> at;
  for (const std::string& name : known) at.push_back(csv.column(name));
  if (!errors.any())
    for (std::size_t k = 0; k < needed.size(); ++k)
      if (!at[k]) errors.add(1, 1, "the column '" + needed[k] + "' is missing");
  NumberTable t;
  for (const CsvRecords::Row& r : csv.rows) {
    std::vector<double> values;
    for (const auto& c : at) {
      if (!c) {
        values.push_back(0);
        continue;
      }
      const CsvCell& cell = r.cells[*c];
      const auto x = parse_number(cell.text);
      if (!x) errors.add(r.line, cell.column, "'" + cell.text + "' is not a number");
      values.push_back(x.value_or(0));
    }
    t.rows.push_back(std::move(values));
    t.lines.push_back(r.line);
  }
  return t;
}

void read_grains(const std::filesystem::path& file, const std::vector<std::string>& materials, FileErrors& errors,
                 std::vector<dem::GrainState>& grains) {
  CsvStream csv(file, errors);
  std::vector<std::string> known = wanted;
  known.insert(known.end(), moving.begin(), moving.end());
  const std::size_t numbers = known.size();
  known.insert(known.end(), {"material", "frozen"});
  for (const std::string& c : csv.columns())
    if (std::find(known.begin(), known.end(), c) == known.end()) {
      const auto near = did_you_mean(c, known);
      errors.add(1, 1, "unknown column '" + c + "'" + (near ? "; did you mean '" + *near + "'?" : ""));
    }
  std::vector<std::optional<std::size_t>> at;
  for (const std::string& name : known) at.push_back(csv.column(name));
  if (!csv.columns().empty())
    for (std::size_t k = 0; k < wanted.size(); ++k)
      if (!at[k]) errors.add(1, 1, "the column '" + wanted[k] + "' is missing");
  const std::size_t before = grains.size();
  std::vector<double> v(numbers);
  for (CsvRecords::Row r; csv.next(r);) {
    std::fill(v.begin(), v.end(), 0.0);
    for (std::size_t k = 0; k < numbers; ++k) {
      if (!at[k]) continue;
      const CsvCell& cell = r.cells[*at[k]];
      const auto x = parse_number(cell.text);
      if (!x) errors.add(r.line, cell.column, known[k] + ": '" + cell.text + "' is not a number");
      v[k] = x.value_or(1);
      if ((k == 3 || k == 4) && x && !(*x > 0))
        errors.add(r.line, cell.column, known[k] + " " + cell.text + " must be positive");
    }
    dem::GrainState g;
    g.x = Vec3(v[0], v[1], v[2]);
    g.radius = v[3];
    g.density = v[4];
    g.v = Vec3(v[5], v[6], v[7]);
    g.w = Vec3(v[8], v[9], v[10]);
    if (at[numbers]) {
      const CsvCell& cell = r.cells[*at[numbers]];
      const auto name = std::find(materials.begin(), materials.end(), cell.text);
      const auto number = parse_number(cell.text);
      if (name != materials.end()) {
        g.material = static_cast<int>(name - materials.begin());
      } else if (number && *number == std::floor(*number) && *number >= 0 &&
                 *number < static_cast<double>(materials.size())) {
        g.material = static_cast<int>(*number);
      } else {
        const auto near = did_you_mean(cell.text, materials);
        errors.add(r.line, cell.column,
                   "there is no material '" + cell.text + "'" + (near ? "; did you mean '" + *near + "'?" : ""));
      }
    }
    if (at[numbers + 1]) {
      const CsvCell& cell = r.cells[*at[numbers + 1]];
      if (cell.text != "0" && cell.text != "1") errors.add(r.line, cell.column, "frozen is 0 or 1");
      g.frozen = cell.text == "1";
    }
    grains.push_back(g);
  }
  if (grains.size() == before && !errors.any()) errors.add(1, 1, "there is no grain in it");
}

ConfigError grain_error(const std::vector<GrainFile>& files, const dem::GrainError& e) {
  Diagnostic d;
  std::string places;
  for (const std::size_t number : e.grains) {
    std::size_t first = 0, k = 0;
    while (k + 1 < files.size() && number >= first + files[k].count) first += files[k++].count;
    const GrainFile& f = files.at(k);
    const std::string name = f.file.string();
    d.file = name;
    d.line = d.column = 0;
    std::string place = fmt::format("number {} of {}", number - first, name);
    if (!f.bed) {
      FileErrors ignored(f.file);
      CsvStream csv(f.file, ignored);
      CsvRecords::Row r;
      for (std::size_t row = first; row <= number && csv.next(r); ++row) d.line = r.line;
      d.column = 1;
      place = fmt::format("{}:{}", name, d.line);
    }
    places += fmt::format("{}grain {} is {}", places.empty() ? "" : ", ", number, place);
  }
  d.message = fmt::format("{} ({})", e.what(), places);
  return ConfigError({d});
}

void write_grains_csv(const std::filesystem::path& file, const std::vector<dem::GrainState>& grains,
                      const std::vector<std::string>& materials) {
  WholeFile out(file);
  out.write("x,y,z,radius,density,vx,vy,vz,wx,wy,wz,material,frozen\n");
  for (const dem::GrainState& g : grains) {
    out.write(fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", g.x[0], g.x[1], g.x[2], g.radius, g.density,
                          g.v[0], g.v[1], g.v[2], g.w[0], g.w[1], g.w[2],
                          materials[static_cast<std::size_t>(g.material)], g.frozen ? 1 : 0));
  }
  out.done();
}

std::string grains_text(const std::vector<dem::GrainState>& grains) {
  StateStream s;
  for (const dem::GrainState& g : grains) {
    double v[] = {g.x[0],
                  g.x[1],
                  g.x[2],
                  g.radius,
                  g.density,
                  g.v[0],
                  g.v[1],
                  g.v[2],
                  g.w[0],
                  g.w[1],
                  g.w[2],
                  g.frozen ? 1.0 : 0.0,
                  double(g.material)};
    s.state().reals("g", v, 13);
  }
  s.finish();
  return fmt::format("\n# {} grains {}\n", grains.size(), s.hash_text());
}

void write_contacts_csv(const std::filesystem::path& file, const std::vector<dem::GrainState>& grains,
                        const dem::Domain& domain, const dem::MaterialTable& materials) {
  double widest = 0;
  for (const dem::GrainState& g : grains) widest = std::max(widest, 2 * g.radius);
  const Vec3 size = domain.hi - domain.lo;
  std::array<long, 3> n{};
  for (int k = 0; k < 3; ++k) n[static_cast<std::size_t>(k)] = std::max(1L, static_cast<long>(size[k] / widest));
  const auto cell = [&](const Vec3& x) {
    std::array<long, 3> c{};
    for (int k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>(k);
      double f = (x[k] - domain.lo[k]) / size[k];
      f -= domain.periodic[a] ? std::floor(f) : 0;
      c[a] = std::clamp(static_cast<long>(f * static_cast<double>(n[a])), 0L, n[a] - 1);
    }
    return c;
  };
  std::vector<std::pair<long, std::uint32_t>> in;  // cell, grain
  in.reserve(grains.size());
  const auto key = [&](long a, long b, long c) { return (a * n[1] + b) * n[2] + c; };
  for (std::size_t g = 0; g < grains.size(); ++g) {
    const auto c = cell(grains[g].x);
    in.emplace_back(key(c[0], c[1], c[2]), static_cast<std::uint32_t>(g));
  }
  std::sort(in.begin(), in.end());
  WholeFile out(file);
  out.write("i,j,x,y,z,nx,ny,nz,overlap_m,normal_elastic_N\n");
  std::vector<std::size_t> partners;
  for (std::size_t i = 0; i < grains.size(); ++i) {
    const auto c = cell(grains[i].x);
    partners.clear();
    for (long a = -1; a <= 1; ++a)
      for (long b = -1; b <= 1; ++b)
        for (long e = -1; e <= 1; ++e) {
          std::array<long, 3> o{c[0] + a, c[1] + b, c[2] + e};
          bool inside = true;
          for (std::size_t k = 0; k < 3; ++k) {
            if (domain.periodic[k]) o[k] = (o[k] + n[k]) % n[k];
            inside = inside && o[k] >= 0 && o[k] < n[k];
          }
          if (!inside) continue;
          // Partners come after i.
          const std::pair<long, std::uint32_t> from{key(o[0], o[1], o[2]), static_cast<std::uint32_t>(i + 1)};
          for (auto it = std::lower_bound(in.begin(), in.end(), from); it != in.end() && it->first == from.first; ++it)
            partners.push_back(it->second);
        }
    std::sort(partners.begin(), partners.end());
    partners.erase(std::unique(partners.begin(), partners.end()), partners.end());
    for (std::size_t j : partners) {
      Vec3 d = grains[j].x - grains[i].x;
      for (int k = 0; k < 3; ++k)
        if (domain.periodic[static_cast<std::size_t>(k)]) d[k] -= size[k] * std::round(d[k] / size[k]);
      const double ri = grains[i].radius, rj = grains[j].radius, overlap = ri + rj - d.norm();
      if (!(overlap > 0)) continue;
      const Vec3 normal = d.normalized(), at = grains[i].x + (ri - 0.5 * overlap) * normal;
      const auto& mi = materials.materials[static_cast<std::size_t>(grains[i].material)];
      const auto& mj = materials.materials[static_cast<std::size_t>(grains[j].material)];
      const double modulus = 1 / ((1 - mi.poisson * mi.poisson) / mi.young + (1 - mj.poisson * mj.poisson) / mj.young);
      const double force = 4.0 / 3 * modulus * std::sqrt(ri * rj / (ri + rj) * overlap) * overlap;
      out.write(fmt::format("{},{},{:.9g},{:.9g},{:.9g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", i, j, at[0], at[1],
                            at[2], normal[0], normal[1], normal[2], overlap, force));
    }
  }
  out.done();
}

}  // namespace grouser::app
