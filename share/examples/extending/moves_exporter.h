#pragma once

#include "dynemo/exporters/exporter.h"

namespace dynemo {

/// moves.csv: one row per move of an object.
std::unique_ptr<Exporter> makeMovesExporter(const ExportParams& params);

}  // namespace dynemo
