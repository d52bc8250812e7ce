#include <gtest/gtest.h>

#include "dynemo/batch/slurm.h"
#include "generated_rawlog.h"

namespace dynemo::test {
namespace {

TEST(SlurmScript, IsAnArrayOfOneTaskPerItem) {
  const TemporaryFolder folder;
  const RunStore store(folder / "wo rk");
  SlurmParams params;
  params.program = "/opt/it's/dynemo-batch";
  const SlurmJob job{.id = "", .folder = folder / "job", .tasks = 5};
  const std::string script = slurmScript(job, store, params);
  EXPECT_EQ(script.rfind("#!/bin/sh\n", 0), 0U);
  EXPECT_NE(script.find("#SBATCH --array=0-4\n"), std::string::npos);
  EXPECT_NE(script.find("exec '/opt/it'\\''s/dynemo-batch' --work '" + (folder / "wo rk").string() +
                        "' --task '" + (folder / "job" / "work.json").string() +
                        "' --index \"$SLURM_ARRAY_TASK_ID\"\n"),
            std::string::npos)
      << script;
  params.jobs = 2;
  EXPECT_NE(slurmScript(job, store, params).find("--array=0-4%2\n"), std::string::npos);
}

TEST(SbatchReason, IsOneLine) {
  EXPECT_EQ(sbatchReason("sbatch: error: invalid partition specified: nowhere\n"
                         "sbatch: error: Batch job submission failed: Invalid partition name "
                         "specified\n"),
            "invalid partition specified: nowhere; Batch job submission failed: Invalid partition "
            "name specified");
  EXPECT_EQ(sbatchReason(""), "no reason given");
}

}  // namespace
}  // namespace dynemo::test
