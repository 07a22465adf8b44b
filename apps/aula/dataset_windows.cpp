#include "apps/aula/commands.h"
#include "apps/dataset/merge/merge.h"
#include "aula/exception.h"

namespace aula {

// No dataset is merged there.
std::optional<MergeFormat> merge_format(const std::string&) { return std::nullopt; }

int dataset(const DatasetArguments&) {
    throw InputError("dataset: Aula makes no datasets on Windows; expected another command");
}

}  // namespace aula
