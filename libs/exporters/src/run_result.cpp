#include "dynemo/exporters/run_result.h"

namespace dynemo {

const PointOwners& pointOwners(const RunResult& run, const StructureParams& structure,
                               const QueryParams& query) {
  SharedFindings& shared = *run.findings;
  if (!shared.owners || shared.structure != structure || shared.query != query) {
    shared.owners =
        std::make_unique<PointOwners>(run.graph, run.entity_covariances, structure, query);
    shared.structure = structure;
    shared.query = query;
  }
  return *shared.owners;
}

}  // namespace dynemo
