// What the web page consists of; that it works is tried in a browser elsewhere.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "small_run.h"
#include "web_assets.h"

namespace dynemo::test {
namespace {

std::string dataOf(const std::string& page) {
  const std::string tag = "<script type=\"application/json\" id=\"data\">";
  const std::size_t begin = page.find(tag) + tag.size();
  return page.substr(begin, page.find("</script>", begin) - begin);
}

TEST(WebPage, HoldsTheRunAsJson) {
  const SmallRun run = smallRun();
  const auto data = nlohmann::json::parse(dataOf(exported("html", run.result())));
  EXPECT_EQ(data.at("keyframes").size(), 3u);
  EXPECT_EQ(data.at("entities").size(), 2u);
  EXPECT_EQ(data.at("entities").at(0).at("moves").size(), 1u);
  EXPECT_EQ(data.at("floors").size(), 1u);
  EXPECT_EQ(data.at("edges").size(), 5u);
  EXPECT_NEAR(data.at("duration").get<double>(), 0.4, 1e-9);
}

TEST(WebPage, NamesCannotEndTheScript) {
  SmallRun run = smallRun();
  const std::string name = "</script><script>alert(1)</script>\xff";
  for (const auto& node : run.graph.tracks().at({101})) node->name = name;
  const std::string page = exported("html", run.result());
  EXPECT_EQ(page.find("alert(1)</script>"), std::string::npos);
  const auto data = nlohmann::json::parse(dataOf(page));
  EXPECT_NE(data.at("entities").at(1).at("title").get<std::string>().find("</script><script>"),
            std::string::npos);
}

TEST(WebPage, NeedsNothingElse) {
  const SmallRun run = smallRun();
  const std::string page = exported("html", run.result());
  for (const char* link : {"src=\"", "<link", "@import", "@DATA@", "@THREE@"})
    EXPECT_EQ(page.substr(0, page.find("id=\"data\"")).find(link), std::string::npos) << link;
  EXPECT_NE(page.find(threeScript()), std::string::npos);
  EXPECT_NE(page.find("Copyright © 2010-2019 three.js authors"), std::string::npos);
}

}  // namespace
}  // namespace dynemo::test
