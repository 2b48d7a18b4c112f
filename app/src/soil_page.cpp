#include "soil_page.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace grouser::app {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<double> scaled(std::vector<double> v, double s) {
  for (double& x : v) x *= s;
  return v;
}

std::size_t column(const SoilGroup& g, const std::string& name) {
  return static_cast<std::size_t>(std::find(g.columns.begin(), g.columns.end(), name) - g.columns.begin());
}

void add_curves(report::FigurePage& page, const std::vector<const SoilGroup*>& groups, const std::string& title,
                const std::string& name, const std::string& x_label, const std::string& y_label, double y_scale,
                const std::vector<report::Series>& references) {
  report::Plot plot{title, x_label, y_label, "Mean over packings; bars: standard deviation over packings.",
                    {},    false,   false};
  int colour = 0;
  for (const SoilGroup* g : groups) {
    const std::size_t c = column(*g, name);
    report::Series line{fmt::format("{} (n = {})", g->variant.empty() ? g->curve : g->variant, g->packings),
                        report::Series::Style::line,
                        scaled(g->x, 1e3),
                        scaled(g->mean[c], y_scale),
                        {},
                        colour};
    plot.series.push_back(line);
    if (g->packings > 1) {
      // Bars at every tenth point, so that they can be told apart.
      report::Series bars{"", report::Series::Style::points, {}, {}, {}, colour};
      bars.name = "spread of " + line.name;
      const std::size_t step = std::max<std::size_t>(1, g->x.size() / 10);
      for (std::size_t k = step / 2; k < g->x.size(); k += step) {
        bars.x.push_back(line.x[k]);
        bars.y.push_back(line.y[k]);
        bars.error.push_back(y_scale * g->sd[c][k]);
      }
      plot.series.push_back(std::move(bars));
    }
    colour = (colour + 1) % 7;
  }
  for (const report::Series& s : references) plot.series.push_back(s);
  page.items.push_back(std::move(plot));
}

report::FigureTable values_table(const SoilFile& f, const std::vector<SoilGroup>& groups) {
  const bool shear = f.kind == "direct-shear";
  const std::vector<double> places =
      shear ? std::vector<double>{0.1, 0.25, 0.5, 1.0} : std::vector<double>{0.25, 0.5, 0.75, 1.0};
  report::FigureTable t{shear ? "Shear stress of box and plate [kPa], mean +- sd over packings"
                              : "Pressure [kPa], mean +- sd over packings",
                        {"case", "packings"},
                        {}};
  if (groups.empty()) return t;
  if (!shear && f.kind != "pressure-sinkage") {
    t.title = "At the end, mean +- sd over packings";
    for (const std::string& c : groups[0].columns) t.columns.push_back(c);
    for (const SoilGroup& g : groups) {
      std::vector<std::string> row{g.name, std::to_string(g.packings)};
      for (std::size_t c = 0; c < g.columns.size(); ++c)
        row.push_back(g.packings > 1 ? fmt::format("{:.4g} +- {:.2g}", g.mean[c].back(), g.sd[c].back())
                                     : fmt::format("{:.4g}", g.mean[c].back()));
      t.rows.push_back(std::move(row));
    }
    return t;
  }
  const double whole = groups[0].x.back();
  for (double p : places) t.columns.push_back(fmt::format("{:.2f} mm", 1e3 * p * whole));
  const std::string name = shear ? "shear_total_Pa" : "pressure_Pa";
  for (const SoilGroup& g : groups) {
    std::vector<std::string> row{g.name, std::to_string(g.packings)};
    const std::size_t c = column(g, name);
    for (double p : places) {
      const double m = value_at(g.x, g.mean[c], p * whole), s = value_at(g.x, g.sd[c], p * whole);
      row.push_back(std::isnan(m)    ? "-"
                    : g.packings > 1 ? fmt::format("{:.2f} +- {:.2f}", 1e-3 * m, 1e-3 * s)
                                     : fmt::format("{:.2f}", 1e-3 * m));
    }
    t.rows.push_back(std::move(row));
  }
  if (f.reference.shear) {
    std::vector<double> pressures;
    for (const SoilGroup& g : groups) {
      const double p = std::get<dem::ShearSettings>(g.first->test).pressure;
      if (std::find(pressures.begin(), pressures.end(), p) == pressures.end()) pressures.push_back(p);
    }
    for (double p : pressures) {
      std::vector<std::string> row{fmt::format("{}, {:g} Pa", f.reference.source, p), ""};
      for (double q : places) row.push_back(fmt::format("{:.2f}", 1e-3 * f.reference.shear_stress(p, q * whole)));
      t.rows.push_back(std::move(row));
    }
  } else if (f.reference.sinkage) {
    std::vector<std::string> row{f.reference.source, ""};
    for (double q : places) row.push_back(fmt::format("{:.2f}", 1e-3 * f.reference.pressure(q * whole)));
    t.rows.push_back(std::move(row));
  }
  return t;
}

/// Angles of internal friction of a triaxial test: its largest, and the mean over the last fifth of the strain.
report::FigureTable strength_table(const std::vector<SoilGroup>& groups, const std::vector<SoilCaseResult>& results) {
  report::FigureTable t{"Angle of internal friction [deg], mean +- sd over packings",
                        {"case", "packings", "peak", "last fifth of the strain"},
                        {}};
  for (const SoilGroup& g : groups) {
    std::vector<double> peak, late;
    for (const SoilCaseResult& r : results) {
      if (!r.done || r.spec->group != g.name) continue;
      const std::vector<double> phi = r.table.column("mobilised_friction_deg");
      peak.push_back(*std::max_element(phi.begin(), phi.end()));
      const std::size_t from = phi.size() - std::max<std::size_t>(1, phi.size() / 5);
      late.push_back(0);
      for (std::size_t k = from; k < phi.size(); ++k) late.back() += phi[k] / static_cast<double>(phi.size() - from);
    }
    std::vector<std::string> row{g.name, std::to_string(g.packings)};
    for (const std::vector<double>& v : {peak, late}) {
      double mean = 0, square = 0;
      for (double x : v) mean += x / static_cast<double>(v.size());
      for (double x : v) square += (x - mean) * (x - mean);
      row.push_back(v.size() > 1
                        ? fmt::format("{:.1f} +- {:.1f}", mean, std::sqrt(square / static_cast<double>(v.size() - 1)))
                        : fmt::format("{:.1f}", mean));
    }
    t.rows.push_back(std::move(row));
  }
  return t;
}

}  // namespace

double value_at(const std::vector<double>& x, const std::vector<double>& y, double q) {
  if (x.empty() || q < x.front() || q > x.back()) return nan;
  const auto k = static_cast<std::size_t>(std::lower_bound(x.begin(), x.end(), q) - x.begin());
  if (k == 0) return y[0];
  const double w = (q - x[k - 1]) / (x[k] - x[k - 1]);
  return (1 - w) * y[k - 1] + w * y[k];
}

std::vector<SoilGroup> group_curves(const std::vector<SoilCaseResult>& results) {
  std::vector<std::pair<SoilGroup, std::vector<const SoilCaseResult*>>> all;
  for (const SoilCaseResult& r : results) {
    if (!r.done) continue;
    auto it = std::find_if(all.begin(), all.end(), [&](const auto& a) { return a.first.name == r.spec->group; });
    if (it == all.end()) {
      all.push_back({});
      it = all.end() - 1;
      it->first.name = r.spec->group;
      it->first.variant = r.spec->variant;
      it->first.curve = r.spec->curve;
      it->first.first = r.spec;
      it->first.first_column = r.table.columns[0];
    }
    it->second.push_back(&r);
  }
  std::vector<SoilGroup> out;
  for (auto& [g, members] : all) {
    g.packings = members.size();
    const dem::Table& t = members[0]->table;
    g.x = t.column(t.columns[0]);
    g.columns.assign(t.columns.begin() + 1, t.columns.end());
    for (const std::string& name : g.columns) {
      std::vector<double> mean(g.x.size(), 0.0), sd(g.x.size(), 0.0);
      for (std::size_t k = 0; k < g.x.size(); ++k) {
        // Packings end at slightly different depths: each at the places of the first. Loads go up and down: row by row.
        std::vector<double> values;
        const bool by_row = std::holds_alternative<dem::OedometerSettings>(g.first->test);
        for (const SoilCaseResult* r : members) {
          const std::vector<double> y = r->table.column(name);
          const double v = by_row ? y.at(k) : value_at(r->table.column(t.columns[0]), y, g.x[k]);
          if (!std::isnan(v)) values.push_back(v);
        }
        for (double v : values) mean[k] += v / static_cast<double>(values.size());
        if (values.size() > 1) {
          for (double v : values) sd[k] += (v - mean[k]) * (v - mean[k]);
          sd[k] = std::sqrt(sd[k] / static_cast<double>(values.size() - 1));
        }
      }
      g.mean.push_back(std::move(mean));
      g.sd.push_back(std::move(sd));
    }
    out.push_back(std::move(g));
  }
  return out;
}

std::string mean_csv(const std::vector<SoilGroup>& groups) {
  std::string out;
  for (const SoilGroup& g : groups) {
    if (out.empty()) {
      out = "group,packings," + g.first_column;
      for (const std::string& c : g.columns) out += "," + c + "," + c + "_sd";
      out += '\n';
    }
    for (std::size_t k = 0; k < g.x.size(); ++k) {
      out += fmt::format("\"{}\",{},{:.9g}", g.name, g.packings, g.x[k]);
      for (std::size_t c = 0; c < g.columns.size(); ++c) out += fmt::format(",{:.9g},{:.9g}", g.mean[c][k], g.sd[c][k]);
      out += '\n';
    }
  }
  return out;
}

report::FigurePage soil_page(const SoilFile& f, const std::vector<SoilCaseResult>& results) {
  const std::vector<SoilGroup> groups = group_curves(results);
  std::size_t done = 0;
  for (const SoilCaseResult& r : results) done += r.done;
  report::FigurePage page{
      f.title, fmt::format("{} of {} cases finished; {}", done, results.size(), f.file.filename().string()), {}};
  if (groups.empty()) return page;
  page.items.push_back(values_table(f, groups));
  const auto line = [](std::string name, auto&& y, double last, double y_scale) {
    report::Series s{std::move(name), report::Series::Style::dashed, {}, {}, {}, 7};
    for (int k = 0; k <= 200; ++k) {
      const double x = last * k / 200;
      s.x.push_back(1e3 * x);
      s.y.push_back(y_scale * y(x));
    }
    return s;
  };
  if (f.kind == "triaxial") page.items.push_back(strength_table(groups, results));
  if (f.kind == "angle-of-repose" || f.kind == "oedometer" || f.kind == "triaxial") {
    for (const std::string& c : groups[0].columns) {
      report::Plot plot{
          c,    f.kind == "oedometer" ? "pressure [kPa]" : f.kind == "triaxial" ? "axial strain" : "time [s]",
          c,    "Mean over packings; bars: standard deviation over packings.",
          {},   false,
          false};
      for (const SoilGroup& g : groups)
        plot.series.push_back({fmt::format("{} (n = {})", g.name, g.packings), report::Series::Style::line,
                               scaled(g.x, f.kind == "oedometer" ? 1e-3 : 1), g.mean[column(g, c)],
                               g.packings > 1 ? g.sd[column(g, c)] : std::vector<double>{}, -1});
      page.items.push_back(std::move(plot));
    }
  } else if (f.kind == "direct-shear") {
    // One figure per pressure and rate: variants side by side.
    std::vector<std::string> curves;
    for (const SoilGroup& g : groups)
      if (std::find(curves.begin(), curves.end(), g.curve) == curves.end()) curves.push_back(g.curve);
    for (const std::string& curve : curves) {
      std::vector<const SoilGroup*> these;
      for (const SoilGroup& g : groups)
        if (g.curve == curve) these.push_back(&g);
      const double p = std::get<dem::ShearSettings>(these[0]->first->test).pressure;
      std::vector<report::Series> references;
      if (f.reference.shear)
        references.push_back(line(
            f.reference.source, [&](double j) { return f.reference.shear_stress(p, j); }, these[0]->x.back(), 1e-3));
      add_curves(page, these, "Shear stress, " + curve, "shear_total_Pa", "displacement [mm]",
                 "shear stress of box and plate [kPa]", 1e-3, references);
      add_curves(page, these, "Shear stress of the upper box alone, " + curve, "shear_box_Pa", "displacement [mm]",
                 "shear stress [kPa]", 1e-3, references);
      add_curves(page, these, "Rise of the plate, " + curve, "rise_m", "displacement [mm]", "rise [mm]", 1e3, {});
    }
  } else {
    std::vector<const SoilGroup*> these;
    for (const SoilGroup& g : groups) these.push_back(&g);
    std::vector<report::Series> references;
    if (f.reference.sinkage)
      references.push_back(line(
          f.reference.source, [&](double z) { return f.reference.pressure(z); }, these[0]->x.back(), 1e-3));
    add_curves(page, these, "Pressure under the plate", "pressure_Pa", "sinkage [mm]", "pressure [kPa]", 1e-3,
               references);
  }
  for (const SoilCaseResult& r : results)
    if (!r.failure.empty()) page.items.push_back(report::Paragraph{r.spec->name + " stopped: " + r.failure});
  return page;
}

}  // namespace grouser::app
