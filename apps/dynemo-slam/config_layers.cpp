#include "config_layers.h"

#include <algorithm>

#include "dynemo/core/config.h"
#include "dynemo/core/error.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

/// share/dynemo/config beside the program's own folder, in the build tree as when installed.
fs::path setupFolder() {
  std::error_code failure;
  const fs::path program = fs::read_symlink("/proc/self/exe", failure);
  return program.parent_path().parent_path() / "share" / "dynemo" / "config" / "setups";
}

}  // namespace

std::vector<std::string> setupNames() {
  std::vector<std::string> names;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(setupFolder(), failure)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

DynemoParams loadParams(const ConfigLayers& layers) {
  ConfigLoader loader;
  if (layers.setup) {
    const auto names = setupNames();
    if (std::find(names.begin(), names.end(), *layers.setup) == names.end()) {
      std::string known;
      for (const auto& name : names) known += (known.empty() ? "" : ", ") + name;
      throw ConfigError("--setup " + *layers.setup + ": no such setup; known: " + known);
    }
    loader.addFile(setupFolder() / (*layers.setup + ".yaml"));
  }
  if (layers.file) loader.addFile(*layers.file);
  for (const std::string& override_text : layers.overrides) loader.addOverride(override_text);
  DynemoParams params;
  load(loader, params);
  return params;
}

}  // namespace dynemo
