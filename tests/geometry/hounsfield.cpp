#include "turgor/geometry/hounsfield.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "turgor/geometry/phantom.hpp"

namespace turgor {
namespace {

CtVolume small_phantom(PhantomKind kind) {
  PhantomParams params = default_phantom(kind);
  params.size = {params.size.x / 8, params.size.y / 8, params.size.z / 8};
  params.spacing *= 8;
  return make_phantom(Exec(2), params);
}

CtVolume changed(CtVolume ct, const std::function<double(int)>& to) {
  for (auto& hu : ct.samples) hu = std::int16_t(std::lround(to(hu)));
  return ct;
}

// The phantoms pass the plausibility check.
TEST(Hounsfield, PhantomsArePlausible) {
  for (const PhantomKind kind : {PhantomKind::kTorso, PhantomKind::kHead, PhantomKind::kLeg})
    EXPECT_EQ(doubt_of_hounsfield_units(small_phantom(kind)), "");
}

// A crop from inside a body, without air, passes the plausibility check.
TEST(Hounsfield, CropInsideBodyIsPlausible) {
  CtVolume crop = small_phantom(PhantomKind::kTorso);
  std::erase_if(crop.samples, [](int hu) { return hu < -200; });
  EXPECT_EQ(doubt_of_hounsfield_units(crop), "");
}

// Gray values, shifted, scaled or inverted images and empty images fail the plausibility check.
TEST(Hounsfield, OtherImagesAreImplausible) {
  const CtVolume torso = small_phantom(PhantomKind::kTorso);
  const struct {
    const char* what;
    std::function<double(int)> to;
  } images[] = {{"gray values of 0 to 255", [](int hu) { return std::clamp((hu + 1000) / 8.0, 0.0, 255.0); }},
                {"a scale that was left out", [](int hu) { return std::max(hu + 1024, 0); }},
                {"twice shifted", [](int hu) { return hu - 1024; }},
                {"inverted", [](int hu) { return -hu; }},
                {"a map of vessels", [](int hu) { return hu > 150 && hu < 300 ? 1 : 0; }},
                {"nothing", [](int) { return 0; }}};
  for (const auto& image : images) {
    const std::string doubt = doubt_of_hounsfield_units(changed(torso, image.to));
    EXPECT_NE(doubt.find("do not look like Hounsfield units"), std::string::npos) << image.what;
    EXPECT_NE(doubt.find(" % are near air (-1100 to -900)"), std::string::npos) << doubt;
  }
}

}  // namespace
}  // namespace turgor
