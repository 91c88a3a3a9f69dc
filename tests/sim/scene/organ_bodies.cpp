// [organs] becomes bodies, attachments and contacts.
#include "turgor/sim/scene/organ_bodies.hpp"

#include <gtest/gtest.h>

#include "turgor/sim/scene/scene.hpp"

namespace turgor {
namespace {

constexpr const char* kOrgans = R"([organs]
labels = { phantom = "torso", size = [96, 96, 56] }
bodies = ["liver", "gallbladder", 6]
young = 4e3
attachment = { stiffness_per_area = 1e5, slack = 0.001 }
contact = { friction = 0.05 }
[body.liver]
fixed = "back"
young = 6e3
)";

Scene scene_of(const std::string& text) {
  Result<Scene> scene = parse_scene(text, "organs.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}

// Every label is a body with the keys of the table, its own keys count first, and every pair is tied and
// touches.
TEST(OrganBodies, Table_BecomesBodiesAndPairs) {
  const Scene scene = scene_of(kOrgans);
  ASSERT_EQ(scene.sfem_bodies.size(), 3u);
  for (const SfemScene& body : scene.sfem_bodies) {
    const bool is_liver = body.name == "liver";
    EXPECT_EQ(body.is_free, !is_liver) << body.name;
    EXPECT_EQ(body.material.young, is_liver ? 6e3 : 4e3) << body.name;
    const int label = std::get<LabeledOrgan>(body.source).label;
    EXPECT_EQ(label, is_liver ? 5 : body.name == "gallbladder" ? 4 : 6) << body.name;
  }
  ASSERT_EQ(scene.attachments.size(), 3u);
  ASSERT_EQ(scene.body_contacts.size(), 3u);
  for (const AttachmentScene& attachment : scene.attachments) {
    EXPECT_TRUE(attachment.is_optional);
    EXPECT_EQ(attachment.slack, 0.001);
    EXPECT_NE(attachment.body, *attachment.other);
  }
}

// Labels of other bodies from the same segmentation stay cavities of a body that encloses them.
TEST(OrganBodies, LabelsOfOthersAreKnown) {
  const Scene scene = scene_of(kOrgans);
  for (const SfemScene& body : scene.sfem_bodies) {
    const auto& organ = std::get<LabeledOrgan>(body.source);
    EXPECT_TRUE(organ.are_cavities_filled) << body.name;
    ASSERT_EQ(organ.of_others.size(), 2u) << body.name;
    EXPECT_EQ(organ.label + organ.of_others[0] + organ.of_others[1], 4 + 5 + 6) << body.name;
  }
}

// An attachment of the scene itself replaces that of the table.
TEST(OrganBodies, OwnAttachment_Replaces) {
  const Scene scene = scene_of(std::string(kOrgans) +
                               "[attachment.bed]\nbetween = [\"liver\", \"gallbladder\"]\nstiffness = 7\n");
  ASSERT_EQ(scene.attachments.size(), 3u);
  int own = 0;
  for (const AttachmentScene& attachment : scene.attachments) own += attachment.stiffness == 7;
  EXPECT_EQ(own, 1);
}

// Neighbors are attached also where the table does not say so, unless it says "none".
TEST(OrganBodies, Neighbors_AreAttachedByDefault) {
  const std::string text = kOrgans;
  const std::string line = "attachment = { stiffness_per_area = 1e5, slack = 0.001 }\n";
  const std::size_t at = text.find(line);
  ASSERT_NE(at, std::string::npos);
  const Scene silent = scene_of(std::string(text).erase(at, line.size()));
  ASSERT_EQ(silent.attachments.size(), 3u);
  for (const AttachmentScene& attachment : silent.attachments) {
    EXPECT_TRUE(attachment.is_optional);
    EXPECT_EQ(attachment.stiffness_per_area, 1e5);
  }
  const Scene none = scene_of(std::string(text).replace(at, line.size(), "attachment = \"none\"\n"));
  EXPECT_EQ(none.attachments.size(), 0u);
  EXPECT_EQ(none.body_contacts.size(), 3u);
}

// A file given by an override is looked for in the current folder, as for a body.
TEST(OrganBodies, OverriddenLabels_AreOfCurrentFolder) {
  const Result<Scene> scene = parse_scene(kOrgans, "/elsewhere/organs.toml", {"organs.labels=seg.nii"});
  ASSERT_TRUE(scene) << scene.error().message;
  for (const SfemScene& body : scene->sfem_bodies)
    EXPECT_EQ(std::get<LabeledOrgan>(body.source).file, "seg.nii") << body.name;
}

// A table without bodies, and a misspelt key, are explained.
TEST(OrganBodies, Mistakes_AreExplained) {
  const auto error = [](const std::string& text) {
    const Result<Scene> scene = parse_scene(text, "organs.toml");
    return scene ? std::string() : scene.error().message;
  };
  EXPECT_NE(error("[organs]\nlabels = \"m.nii\"\n").find("expected the labels of the bodies"),
            std::string::npos);
  const std::string head = "[organs]\nlabels = \"m.nii\"\nbodies = [\"liver\", \"stomach\"]\n";
  EXPECT_NE(error(head + "attachment = true\n").find("or \"none\""), std::string::npos);
  EXPECT_NE(error(head + "contact = 3\n").find("the keys of a contact"), std::string::npos);
  EXPECT_NE(error(std::string(kOrgans) + "[body.gallbladder]\nyuong = 3\n").find("yuong is not a key"),
            std::string::npos);
}

}  // namespace
}  // namespace turgor
