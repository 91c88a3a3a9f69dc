// Replaces turgor/io/dicom/dicom_decode.cpp in the slim module, which reads uncompressed DICOM only.
#include "turgor/io/dicom/dicom.hpp"

namespace turgor::io {

Result<ChangedSamples> decode_dicom_samples(const Exec&, std::span<const DicomSlice* const> slices,
                                            std::span<const std::span<std::int16_t>>, const Progress&) {
  const std::string file = slices.empty() ? "DICOM" : slices[0]->file.string();
  return Error{
      file +
      ": this build of turgor has no GDCM, which compressed DICOM needs; expected uncompressed samples"};
}

}  // namespace turgor::io
