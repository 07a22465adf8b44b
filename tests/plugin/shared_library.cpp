#include "tests/plugin/shared_library.h"

#include <filesystem>
#include <stdexcept>

#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace aula::test {

#if defined(_WIN32)

SharedLibrary::SharedLibrary(const std::string& file)
    : handle_(LoadLibraryW(std::filesystem::path(file).make_preferred().c_str())) {
    if (handle_ == nullptr)
        throw std::runtime_error(file + ": error " + std::to_string(GetLastError()));
}

void* SharedLibrary::address(const char* name) const {
    return reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(handle_), name));
}

#else

SharedLibrary::SharedLibrary(const std::string& file) : handle_(dlopen(file.c_str(), RTLD_NOW)) {
    if (handle_ == nullptr) throw std::runtime_error(dlerror());
}

void* SharedLibrary::address(const char* name) const { return dlsym(handle_, name); }

#endif

}  // namespace aula::test
