#include "grouser/diagnosis/fit_file.h"

#include <cmath>
#include <cstdio>
#include <fstream>

#include "grouser/terrain/config.h"
#include "grouser/terrain/recorder.h"
#include "sections.h"

namespace grouser::diagnosis {

std::string shown(double x, int digits) {
  if (std::isnan(x)) return "-";
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, x);
  return text;
}

ShownParameter shown_parameter(const Estimate& e, const std::string& name, const std::string& unit, double scale) {
  ShownParameter p{name, unit, e.value * scale, e.standard_error * scale, e.lower * scale, e.upper * scale, {}};
  if (e.logarithmic) p.standard_error *= e.value;
  const auto note = [&](const std::string& text) { p.note += (p.note.empty() ? "" : "; ") + text; };
  if (e.at_bound) note("at its bound, held there");
  if (!e.at_bound && std::isnan(e.standard_error)) note("no error: not identifiable");
  if (!e.logarithmic && e.lower < 0 && e.upper > 0) note("not distinguishable from 0");
  if (e.logarithmic && e.standard_error > 0.7)
    note("known to a factor of " + shown(std::exp(2 * e.standard_error), 2) + " only");
  if (e.prior_z != 0)
    note("prior z = " + shown(e.prior_z, 3) + (std::abs(e.prior_z) > 3 ? ", in conflict with the prior" : ""));
  return p;
}

std::vector<std::string> general_remarks(const LeastSquaresResult& fit) {
  std::vector<std::string> out;
  if (!fit.converged) out.push_back("The minimiser did not converge: " + fit.message);
  for (const WeakDirection& w : fit.weak)
    out.push_back((w.condition_index > 1e7 ? "Not identifiable: " : "Poorly identified: ") +
                  std::string("the data hardly change along ") + w.text + " (condition index " +
                  shown(w.condition_index, 3) + "; above 30 counts as near-collinear).");
  for (const Estimate& e : fit.estimates)
    if (e.at_bound)
      out.push_back("'" + e.name + "' ends on its bound " + shown(e.value) +
                    "; the other errors hold for this value of it.");
  if (fit.starts > 1 && fit.starts_agreeing < fit.starts)
    out.push_back(std::to_string(fit.starts_agreeing) + " of " + std::to_string(fit.starts) +
                  " starts end within 1 % of the least sum of squares, the others above it.");
  return out;
}

std::vector<std::pair<std::string, std::vector<std::size_t>>> grouped(const std::vector<std::string>& labels) {
  std::vector<std::pair<std::string, std::vector<std::size_t>>> out;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    std::size_t g = 0;
    while (g < out.size() && out[g].first != labels[i]) ++g;
    if (g == out.size()) out.push_back({labels[i], {}});
    out[g].second.push_back(i);
  }
  return out;
}

ErrorModel error_model(const ConfigNode& node, const std::string& fallback) {
  const std::string e = node.choice_or("errors", fallback, {"stated", "scaled", "clustered"});
  return e == "stated" ? ErrorModel::stated : e == "scaled" ? ErrorModel::scaled : ErrorModel::clustered;
}

FitReport run_fit(const std::filesystem::path& yaml) {
  const ConfigDocument document = ConfigDocument::from_file(yaml);
  const ConfigNode root = document.root();
  FitReport report;
  report.title = root.text("fit");
  report.source = root.text("source");
  const std::string soil_name = root.text_or("soil_name", report.title);
  SoilDraft draft;
  if (root.has("base_soil")) draft = draft_of_file(root, "base_soil");
  const ConfigNode shear = root.optional_map("direct_shear"), plates = root.optional_map("pressure_sinkage"),
                   wheel = root.optional_map("wheel");
  if (root.is_map() && !shear.present() && !plates.present() && !wheel.present())
    root.error("nothing to fit; give a section direct_shear, pressure_sinkage or wheel");
  root.finish();
  if (shear.present()) report.sections.push_back(direct_shear_section(shear, draft));
  if (plates.present()) report.sections.push_back(plates_section(plates, draft));
  if (wheel.present()) report.sections.push_back(wheel_section(wheel, draft, report.compare));
  document.check();
  std::tie(report.soil_text, report.soil_note) = soil_file_text(soil_name, report.source, draft);
  return report;
}

namespace {

std::string cell(const std::string& s) { return s.find_first_of(",\"\n") == std::string::npos ? s : '"' + s + '"'; }
std::string cell(double x) { return std::isnan(x) ? "" : shown(x, 9); }

std::ofstream open(const std::filesystem::path& file) {
  std::ofstream out(file);
  if (!out) throw ResultsError(file.string() + ": cannot be written; is the folder writable?");
  return out;
}

void write_table(const std::filesystem::path& file, const FitTable& t) {
  std::ofstream out = open(file);
  const auto line = [&](const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) out << (i ? "," : "") << cell(cells[i]);
    out << '\n';
  };
  line(t.columns);
  for (const auto& row : t.rows) line(row);
}

}  // namespace

void write_fit(const FitReport& r, const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed)
    throw ResultsError(folder.string() + ": cannot be made: " + failed.message() + "; choose another output folder");
  std::ofstream parameters = open(folder / "parameters.csv"), correlation = open(folder / "correlation.csv"),
                fit = open(folder / "fit.csv");
  parameters << "section,parameter,unit,value,standard_error,lower_95,upper_95,note\n";
  correlation << "section,a,b,correlation\n";
  fit << "section,figure,test,x_quantity,y_quantity,x,measured,fitted,residual,stated_error\n";
  for (const FitSection& s : r.sections) {
    for (std::size_t i = 0; i < s.parameters.size(); ++i) {
      const ShownParameter& p = s.parameters[i];
      parameters << s.kind << ',' << p.name << ',' << p.unit << ',' << cell(p.value) << ',' << cell(p.standard_error)
                 << ',' << cell(p.lower) << ',' << cell(p.upper) << ',' << cell(p.note) << '\n';
      for (std::size_t j = 0; j < i; ++j)
        correlation << s.kind << ',' << s.parameters[j].name << ',' << p.name << ','
                    << cell(s.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j))) << '\n';
    }
    for (const FitCurve& c : s.curves)
      for (std::size_t i = 0; i < c.x.size(); ++i)
        fit << s.kind << ',' << cell(c.figure) << ',' << cell(c.name) << ',' << cell(c.x_label) << ','
            << cell(c.y_label) << ',' << cell(c.x[i]) << ',' << cell(c.measured[i]) << ',' << cell(c.fitted[i]) << ','
            << cell(c.fitted[i] - c.measured[i]) << ',' << (c.error.empty() ? "" : cell(c.error[i])) << '\n';
  }
  if (!r.compare.rows.empty()) write_table(folder / "compare.csv", r.compare);
  if (!r.soil_text.empty()) open(folder / "soil.yaml") << r.soil_text;
}

}  // namespace grouser::diagnosis
