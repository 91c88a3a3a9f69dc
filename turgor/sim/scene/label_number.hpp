// Labels of a segmentation as a scene names them: by number, or by the organ's name.
#pragma once

#include <string>

namespace turgor {

/// The number that the usual segmentation tool gives to an organ ("liver" is 5), or that the text is; -1 when
/// it is neither.
int label_number(const std::string& name);
/// "; did you mean liver?" for a misspelt organ.
std::string label_suggestion(const std::string& name);

}  // namespace turgor
