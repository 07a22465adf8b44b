#include "apps/window/model/new_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "aula/exception.h"

namespace aula {

NewFile::NewFile(const std::string& stem, const std::string& extension) {
    for (int number = 1;; ++number) {
        path_ = stem + (number > 1 ? "-" + std::to_string(number) : "") + extension;
        constexpr mode_t kMode = 0666;
        const int descriptor = open(path_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, kMode);
        if (descriptor >= 0) {
            close(descriptor);
            return;
        }
        if (errno == EEXIST) continue;
        throw InputError(path_.string(), "",
                         "cannot be written: " + std::generic_category().message(errno) +
                             "; expected a working directory that can be written to");
    }
}

NewFile::~NewFile() {
    std::error_code error;
    if (std::filesystem::file_size(path_, error) == 0 && !error)
        std::filesystem::remove(path_, error);
}

}  // namespace aula
