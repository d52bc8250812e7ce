// MRPT's 3-D scene file, as SceneViewer3D opens it.
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

#include <limits>
#include <new>

#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"
#include "factories.h"
#include "scene.h"

namespace dynemo {
namespace {

/// As a gzip file, packed in memory: MRPT's own packing goes through a temporary file, and a full
/// disk there goes unnoticed. The header holds no time, so equal scenes give equal bytes.
std::string compressed(const mrpt::opengl::COpenGLScene& scene) {
  mrpt::io::CMemoryStream memory;
  auto archive = mrpt::serialization::archiveFrom(memory);
  archive << scene;

  constexpr int kLevel = 6, kGzipWindow = 15 + 16, kMemoryLevel = 8;
  if (memory.getTotalBytesCount() > std::numeric_limits<uInt>::max()) {
    throw DataError("scene.3Dscene: too large to be compressed");
  }
  z_stream stream{};
  if (deflateInit2(&stream, kLevel, Z_DEFLATED, kGzipWindow, kMemoryLevel, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    throw std::bad_alloc();
  }
  std::string packed(deflateBound(&stream, memory.getTotalBytesCount()), '\0');
  stream.next_in = static_cast<Bytef*>(memory.getRawBufferData());
  stream.avail_in = static_cast<uInt>(memory.getTotalBytesCount());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int result = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) throw DataError("scene.3Dscene: too large to be compressed");
  return packed;
}

class Scene3dExporter : public Exporter {
 public:
  explicit Scene3dExporter(const ExportParams& params) : params_{params} {}
  std::string fileName() const override { return "scene.3Dscene"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    writeFileAtomically(file, compressed(makeScene(run, params_)));
  }

 private:
  SceneParams params_;
};

}  // namespace

std::unique_ptr<Exporter> makeScene3dExporter(const ExportParams& params) {
  return std::make_unique<Scene3dExporter>(params);
}

}  // namespace dynemo
