// What is wrong with a command line, naming the word that is and the known one that is nearest.
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

namespace dynemo {

/// Letters to insert, delete or replace to make one word of the other (Levenshtein).
inline std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

/// The known word that was probably meant; empty when none is near.
inline std::string nearestWord(const std::string& word, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& candidate : known) {
    const bool begun = word.size() >= 2 && candidate.starts_with(word);
    const std::size_t distance = begun ? 1 : editDistance(word, candidate);
    if (distance < least) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

inline std::vector<std::string> commandNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

inline std::vector<std::string> optionNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

inline std::string listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// What the program's own arguments took: one of them may have been meant as the command.
inline std::vector<std::string> positionalWords(const CLI::App& app) {
  std::vector<std::string> words;
  for (const CLI::Option* option : app.get_options())
    if (option->get_positional())
      words.insert(words.end(), option->results().begin(), option->results().end());
  return words;
}

/// No word of the command line is a command.
inline std::string commandError(const CLI::App& app) {
  const std::vector<std::string> commands = commandNames(app), taken = positionalWords(app),
                                 rest = app.remaining();
  for (const auto* words : {&rest, &taken})
    for (const std::string& word : *words)
      if (const std::string nearest = nearestWord(word, commands); !nearest.empty())
        return "'" + word + "' is no command; did you mean " + nearest + "?";
  const std::string known = "; known: " + listed(commands);
  for (const std::string& word : rest)
    if (!word.starts_with('-')) return "'" + word + "' is no command" + known;
  for (const std::string& word : rest)
    if (const std::string nearest = nearestWord(word, optionNames(app)); !nearest.empty())
      return "'" + word + "' is no option; did you mean " + nearest + "?";
  return "a command is required" + (taken.empty() ? "" : " after '" + taken.back() + "'") + known;
}

/// The arguments that neither the program nor its command knows.
inline std::string surplusError(const CLI::App& app, const std::string& what) {
  const auto commands = app.get_subcommands();
  const std::vector<std::string> known = optionNames(commands.empty() ? app : *commands.back());
  for (const std::string& word : app.remaining(true)) {
    const std::string name = word.substr(0, word.find('='));
    const std::string nearest = name.starts_with("--") ? nearestWord(name, known) : "";
    if (!nearest.empty()) return what + "; did you mean " + nearest + "?";
  }
  return what;
}

inline std::string commandLineError(const CLI::App& app, const CLI::ParseError& error) {
  const bool no_command = app.get_require_subcommand_min() > 0 && app.get_subcommands().empty();
  if (no_command && dynamic_cast<const CLI::RequiredError*>(&error) != nullptr)
    return commandError(app);
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr)
    return surplusError(app, error.what());
  return error.what();
}

}  // namespace dynemo
