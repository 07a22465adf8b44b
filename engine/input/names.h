#pragma once

#include <string>
#include <vector>

namespace aula {

/// A name as error messages show it: in double quotes, control characters replaced so that the
/// message stays one line.
std::string quoted(const std::string& name);

/// `"a", "b", "c"`, the first hundred.
std::string quoted_list(const std::vector<std::string>& names);

/// The name that was probably meant: the candidate with the fewest changed characters, upper or
/// lower case, or empty if none is near.
std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates);

/// `, did you mean "stone"?`; if none of the candidates is near, up to three that hold the name; or
/// empty.
std::string did_you_mean(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace aula
