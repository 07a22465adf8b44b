#include "apps/session/play_controls.h"

#include <algorithm>

namespace aula {

bool PlayControls::heard(std::size_t s) const {
    const bool solos = std::any_of(sources.begin(), sources.end(),
                                   [](const SourceControl& source) { return source.solo; });
    return !source(s).muted && (!solos || source(s).solo);
}

}  // namespace aula
