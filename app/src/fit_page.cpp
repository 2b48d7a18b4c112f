#include "fit_page.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace grouser::app {

namespace {

using diagnosis::FitCurve;
using diagnosis::FitSection;
using diagnosis::FitTable;

std::string number(double x) { return std::isnan(x) ? "-" : fmt::format("{:.4g}", x); }

report::FigureTable parameters(const FitSection& s) {
  report::FigureTable t{"Fitted values", {"parameter", "value", "standard error", "95 % interval", "unit", "note"}, {}};
  for (const diagnosis::ShownParameter& p : s.parameters)
    t.rows.push_back({p.name, number(p.value), number(p.standard_error),
                      std::isnan(p.lower) ? "-" : number(p.lower) + " to " + number(p.upper), p.unit, p.note});
  return t;
}

report::FigureTable correlation(const FitSection& s) {
  report::FigureTable t{"Correlation of the estimates", {""}, {}};
  for (const diagnosis::ShownParameter& p : s.parameters) t.columns.push_back(p.name);
  for (std::size_t i = 0; i < s.parameters.size(); ++i) {
    std::vector<std::string> row{s.parameters[i].name};
    for (std::size_t j = 0; j < s.parameters.size(); ++j) {
      const double c = s.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      row.push_back(std::isnan(c) ? "-" : fmt::format("{:.3f}", c));
    }
    t.rows.push_back(std::move(row));
  }
  return t;
}

/// Data as points and the law as a line of the same colour, one pair per test; the residuals below.
void add_figure(const std::vector<const FitCurve*>& curves, report::FigurePage& page) {
  const FitCurve& first = *curves[0];
  report::Plot data{first.figure, first.x_label, first.y_label, "Points: measured. Lines: fitted.", {}, false, false};
  report::Plot residuals{first.figure + ", residuals",
                         first.x_label,
                         "fitted - measured, " + first.y_label,
                         "A trend here is what the law cannot follow.",
                         {},
                         false,
                         false};
  const std::size_t named = 8;  // one colour each; beyond that the points of all tests would hide each other's names
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const FitCurve& c = *curves[i];
    const int colour = static_cast<int>(i % named);
    data.series.push_back({c.name + ", measured", report::Series::Style::points, c.x, c.measured, c.error, colour});
    data.series.push_back({c.name + ", fitted", report::Series::Style::line, c.line_x, c.line_y, {}, colour});
    report::Series r{c.name, report::Series::Style::points, c.x, {}, {}, colour};
    for (std::size_t k = 0; k < c.x.size(); ++k) r.y.push_back(c.fitted[k] - c.measured[k]);
    residuals.series.push_back(std::move(r));
  }
  page.items.push_back(std::move(data));
  page.items.push_back(std::move(residuals));
}

}  // namespace

report::FigurePage fit_page(const diagnosis::FitReport& r) {
  report::FigurePage page{r.title, r.source, {}};
  if (!r.compare.rows.empty())
    page.items.push_back(report::FigureTable{r.compare.title, r.compare.columns, r.compare.rows});
  for (const FitSection& s : r.sections) {
    page.items.push_back(report::Paragraph{s.kind + ": " + s.data});
    page.items.push_back(parameters(s));
    for (const std::string& remark : s.remarks) page.items.push_back(report::Paragraph{remark});
    std::vector<std::string> figures;
    for (const FitCurve& c : s.curves)
      if (std::find(figures.begin(), figures.end(), c.figure) == figures.end()) figures.push_back(c.figure);
    for (const std::string& figure : figures) {
      std::vector<const FitCurve*> curves;
      for (const FitCurve& c : s.curves)
        if (c.figure == figure) curves.push_back(&c);
      add_figure(curves, page);
    }
    for (const FitTable& t : s.tables) page.items.push_back(report::FigureTable{t.title, t.columns, t.rows});
    page.items.push_back(correlation(s));
  }
  return page;
}

}  // namespace grouser::app
