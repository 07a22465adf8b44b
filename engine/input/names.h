#pragma once

#include <string>
#include <vector>

namespace aula {

/// A name for error messages: in double quotes, with control characters replaced, so that the
/// message is one line.
std::string quoted(const std::string& name);

/// `"a", "b", "c"`; at most a hundred names.
std::string quoted_list(const std::vector<std::string>& names);

/// The candidate with the smallest edit distance, ignoring case, or empty if none is near.
std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates);

/// `, did you mean "stone"?`; if no candidate is near, up to three that contain the name; otherwise
/// empty.
std::string did_you_mean(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace aula
