// A file in memory as a stream that notices when its reader asks for more than there is. GDCM fills the missing end of a
// truncated image with zeros and goes on; a body must not be built from those. Internal to io/.
#pragma once

#include <algorithm>
#include <cstring>
#include <streambuf>
#include <string>

namespace turgor::io {

class WholeFile : public std::streambuf {
 public:
  explicit WholeFile(std::string bytes) : bytes_(std::move(bytes)) {
    setg(bytes_.data(), bytes_.data(), bytes_.data() + bytes_.size());
  }
  /// Whether a value was asked for that runs beyond the end. Looking for one more element (8 bytes) does not count.
  bool is_cut_short() const { return cut_short_; }

 protected:
  std::streamsize xsgetn(char* out, std::streamsize count) override {
    const std::streamsize got = std::min<std::streamsize>(count, egptr() - gptr());
    if (got < count && count > 8) cut_short_ = true;
    std::memcpy(out, gptr(), std::size_t(got));
    setg(eback(), gptr() + got, egptr());
    return got;
  }
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    const off_type base = from == std::ios_base::beg ? 0 : from == std::ios_base::cur ? gptr() - eback() : egptr() - eback();
    const off_type limit = egptr() - eback();
    if (offset > limit - base || offset < -base) {
      cut_short_ = true;
      return pos_type(off_type(-1));
    }
    setg(eback(), eback() + base + offset, egptr());
    return pos_type(base + offset);
  }
  pos_type seekpos(pos_type position, std::ios_base::openmode mode) override {
    return seekoff(off_type(position), std::ios_base::beg, mode);
  }

 private:
  std::string bytes_;
  bool cut_short_ = false;
};

}  // namespace turgor::io
