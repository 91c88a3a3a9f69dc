// Decoding of compressed DICOM pixels by GDCM, whose codecs crash on some damaged images.
#include <fstream>
#include <new>
#include <vector>

#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include "reader/tasks.hpp"
#include "turgor/io/dicom/decode_job.hpp"

namespace turgor {

namespace {

using namespace io;

/// The shared memory.
struct Job {
  const DecodeJob* job;
  char* data;

  DecodeSlice& slice(std::size_t k) const {
    return reinterpret_cast<DecodeSlice*>(data + sizeof(DecodeJob))[k];
  }
  const char* text(std::uint64_t at) const { return data + at; }
  char* pixels(std::size_t k) const { return data + job->pixels_at + k * job->slice_bytes; }
};

/// Compressed pixels in GDCM's type.
gdcm::SmartPointer<gdcm::SequenceOfFragments> load_fragments(const Job& job, const DecodeSlice& slice) {
  gdcm::SmartPointer<gdcm::SequenceOfFragments> sequence = new gdcm::SequenceOfFragments;
  const auto* pieces = reinterpret_cast<const DecodeFragment*>(job.data + slice.fragments_at);
  std::ifstream stream(job.text(slice.file_at), std::ios::binary);
  for (std::uint64_t n = 0; n < slice.fragment_count; n++) {
    std::vector<char> bytes(pieces[n].length);
    stream.seekg(std::streamoff(pieces[n].offset));
    stream.read(bytes.data(), std::streamsize(bytes.size()));
    gdcm::Fragment fragment;
    fragment.SetByteValue(bytes.data(), std::uint32_t(bytes.size()));
    sequence->AddFragment(fragment);
  }
  return sequence;
}

/// False if GDCM fails; it may also crash.
bool decode(const Job& job, const DecodeSlice& slice, char* pixels) {
  gdcm::Image image;
  image.SetNumberOfDimensions(2);
  image.SetDimension(0, unsigned(slice.columns));
  image.SetDimension(1, unsigned(slice.rows));
  const auto bits = [](int count) { return static_cast<unsigned short>(count); };
  image.SetPixelFormat(gdcm::PixelFormat(1, bits(slice.bits_allocated), bits(slice.bits_stored),
                                         bits(slice.bits_stored - 1), bits(slice.is_signed)));
  image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  image.SetTransferSyntax(gdcm::TransferSyntax::GetTSType(job.text(slice.syntax_at)));
  gdcm::DataElement element(gdcm::Tag(0x7fe0, 0x0010));
  element.SetVR(gdcm::VR::OB);
  element.SetValue(*load_fragments(job, slice));
  image.SetDataElement(element);
  const std::size_t byte_count =
      std::size_t(slice.columns) * std::size_t(slice.rows) * std::size_t(slice.bits_allocated) / 8;
  return byte_count <= job.job->slice_bytes && image.GetBufferLength() == byte_count &&
         image.GetBuffer(pixels);
}

}  // namespace

bool decode_dicom(int shared_file, std::size_t first, std::size_t step) {
  // the shared memory
  struct stat status {};
  if (fstat(shared_file, &status) != 0 || std::size_t(status.st_size) < sizeof(DecodeJob) || step == 0)
    return false;
  const auto size = std::size_t(status.st_size);
  void* data = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, shared_file, 0);
  if (data == MAP_FAILED) return false;
  const Job job{static_cast<const DecodeJob*>(data), static_cast<char*>(data)};
  if (job.job->size != size) return false;

  // every step-th slice
  for (std::size_t k = first; k < job.job->slice_count; k += step) {
    DecodeSlice& slice = job.slice(k);
    slice.state = Decoding::kWorking;
    bool done = false;
    try {
      done = decode(job, slice, job.pixels(k));
    } catch (const std::bad_alloc&) {
      throw;
    } catch (...) {
    }
    slice.state = done ? Decoding::kDone : Decoding::kRefused;
  }
  return true;
}

}  // namespace turgor
