#include "dynemo/experiments/report.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "dynemo/core/config.h"

namespace dynemo::experiments {
namespace {

std::string formatted(const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '&')
      out += "&amp;";
    else
      out += c;
  }
  return out;
}

std::string withInterval(const MeanInterval& m, int digits) {
  if (m.count == 0) return "–";
  std::string text = formatted("%.*f", digits, m.mean);
  if (m.count > 1) text += formatted("<small> ±%.*f</small>", digits, m.half_width);
  return text;
}

template <class Of>
std::vector<std::string> distinct(const std::vector<Cell>& cells, Of of) {
  std::vector<std::string> names;
  for (const Cell& c : cells)
    if (std::find(names.begin(), names.end(), of(c)) == names.end()) names.push_back(of(c));
  return names;
}

using Ours = std::string (*)(const Cell&);
using Papers = std::string (*)(const PaperRow&);

/// Setups by datasets; in each cell our figure and, in brackets, the paper's.
std::string table(const std::vector<Cell>& cells, const PaperTables& paper,
                  const std::string& odometry, Ours ours, Papers papers) {
  const auto datasets = distinct(cells, [](const Cell& c) { return c.dataset; });
  const auto setups = distinct(cells, [](const Cell& c) { return c.setup; });
  std::string html = "<table><tr><th>Setup</th>";
  for (const auto& dataset : datasets) html += "<th>" + dataset + "</th>";
  html += "</tr>\n";
  for (const auto& setup : setups) {
    html += "<tr><td>" + paperName(setup) + "</td>";
    for (const auto& dataset : datasets) {
      const Cell* cell = findCell(cells, dataset, odometry, setup);
      const PaperRow* row = paper.find(dataset, setup);
      html += "<td>" + (cell ? ours(*cell) : "–");
      if (row && papers) html += " <span class=paper>[" + papers(*row) + "]</span>";
      html += "</td>";
    }
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

std::string tables(const std::vector<Cell>& cells, const PaperTables& paper,
                   const std::string& odometry) {
  struct Column {
    const char* title;
    Ours ours;
    Papers papers;
  };
  const Column columns[] = {
      {"ATE rmse [cm]", [](const Cell& c) { return withInterval(c.ate_rmse_cm, 2); },
       [](const PaperRow& r) { return formatted("%.1f", r.ate_rmse_cm); }},
      {"ATE std [cm]", [](const Cell& c) { return withInterval(c.ate_std_cm, 2); },
       [](const PaperRow& r) { return formatted("%.1f", r.ate_std_cm); }},
      {"ATE of the odometry [cm]", [](const Cell& c) { return withInterval(c.odometry_ate_cm, 2); },
       nullptr},
      {"Loop closures", [](const Cell& c) { return withInterval(c.loop_closures, 1); },
       [](const PaperRow& r) { return std::to_string(r.loop_closures); }},
      {"Optimisation time [ms]", [](const Cell& c) { return withInterval(c.optimization_ms, 2); },
       [](const PaperRow& r) { return formatted("%.0f", r.optimization_ms); }},
      {"Optimisation time of the processor [ms]",
       [](const Cell& c) { return withInterval(c.optimization_cpu_ms, 2); }, nullptr},
      {"Objects: error at the first registration → at the end [cm]",
       [](const Cell& c) {
         return withInterval(c.entity_first_cm, 1) + " → " + withInterval(c.entity_last_cm, 1);
       },
       nullptr}};
  std::string html;
  for (const Column& column : columns)
    html += std::string("<h3>") + column.title + "</h3>\n" +
            table(cells, paper, odometry, column.ours, column.papers);
  return html;
}

/// Table V: each object of the hand-held datasets, ours with the setup full.
std::string entityTable(const ReportInput& input, const std::string& odometry) {
  std::map<std::pair<int, std::string>, std::pair<std::vector<double>, std::vector<double>>> ours;
  std::vector<std::string> datasets;
  for (const RunResult& r : input.results) {
    if (r.key.odometry != odometry || r.key.setup != "full" || r.key.dataset.rfind("R-", 0) != 0)
      continue;
    if (std::find(datasets.begin(), datasets.end(), r.key.dataset) == datasets.end())
      datasets.push_back(r.key.dataset);
    for (const EntityResult& e : r.entities) {
      if (e.semantic_class != "object") continue;
      ours[{e.id, r.key.dataset}].first.push_back(100 * e.first_m);
      ours[{e.id, r.key.dataset}].second.push_back(100 * e.last_m);
    }
  }
  if (datasets.empty()) return "";
  std::string html =
      "<h3>Each object, Full: first → last error [cm]; other objects than the paper's, same "
      "numbers</h3><table><tr><th>Object</th>";
  for (const auto& d : datasets) html += "<th>" + d + "</th>";
  html += "</tr>\n";
  std::vector<int> ids;
  for (const auto& [key, values] : ours)
    if (ids.empty() || ids.back() != key.first) ids.push_back(key.first);
  for (const int id : ids) {
    html += "<tr><td>" + std::to_string(id) + "</td>";
    for (const auto& d : datasets) {
      html += "<td>";
      const auto it = ours.find({id, d});
      if (it != ours.end())
        html += withInterval(meanInterval(it->second.first), 1) + " → " +
                withInterval(meanInterval(it->second.second), 1);
      for (const PaperEntityRow& row : input.paper.entities())
        if (row.entity_id == id && row.dataset == d)
          html += formatted(" <span class=paper>[%.1f → %.1f]</span>", row.first_cm, row.last_cm);
      html += "</td>";
    }
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

std::string claimTable(const std::vector<Claim>& claims) {
  std::string html =
      "<table><tr><th>Claim</th><th>Odometry</th><th>Our runs</th><th>Figures</th></tr>\n";
  for (const Claim& claim : claims)
    html += "<tr><td>" + claim.text + "</td><td>" + claim.odometry + "</td><td>" +
            verdictName(claim.verdict) + "</td><td>" + claim.figures + "</td></tr>\n";
  return html + "</table>\n";
}

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>DYNEMO-SLAM: ablation study</title>
<style>
body { font-family: sans-serif; margin: 2em auto; max-width: 80em; padding: 0 1em; color: #222; }
table { border-collapse: collapse; margin: .5em 0 1.5em; } th, td { border: 1px solid #ccc; padding: .25em .6em; text-align: right; }
th:first-child, td:first-child { text-align: left; } th { background: #f3f3f3; }
.paper { color: #888; } small { color: #666; } figure { display: inline-block; margin: .5em; } svg { max-width: 100%; }
pre { background: #f6f6f6; padding: .6em; }
</style></head><body>
)";

}  // namespace

std::string reportHtml(const ReportInput& input) {
  const std::vector<Cell> cells = cellsOf(input.results);
  std::string html = std::string(kHead) + "<h1>DYNEMO-SLAM: ablation study</h1>\n";
  html +=
      "<p>Means over seeds ± half of the 95 % interval of the mean; in brackets the paper's "
      "figures, which "
      "come from other recordings of the same kind. The plan:</p><pre>" +
      escaped(toYaml(input.plan, false)) + "</pre>\n";
  if (!input.missing.empty()) {
    html += "<h2>Missing runs</h2><ul>\n";
    for (const std::string& text : input.missing) html += "<li>" + escaped(text) + "</li>\n";
    html += "</ul>\n";
  }
  html += "<h2>Claims of the paper</h2>\n" + claimTable(judgeClaims(input.results, input.paper));
  for (const std::string& odometry : distinct(cells, [](const Cell& c) { return c.odometry; }))
    html += "<h2>Odometry: " + odometry + "</h2>\n" + tables(cells, input.paper, odometry) +
            entityTable(input, odometry);
  html += "<h2>Figures</h2>\n";
  for (const Figure& figure : input.figures) {
    const auto begin = figure.svg.find("<svg");
    html += "<figure>" + (begin == std::string::npos ? figure.svg : figure.svg.substr(begin)) +
            "<figcaption>" + figure.caption + "</figcaption></figure>\n";
  }
  return html + "</body></html>\n";
}

}  // namespace dynemo::experiments
