#pragma once

#include <string>
#include <vector>

#include "apps/bench/base/table.h"

namespace aula::bench {

/// A Markdown document of measurements: command, machine, compiler, commit and date, then a section
/// for each table.
class MeasurementFile {
 public:
    /// `command` is the command line that the document names as its origin. Takes the date and the
    /// machine's load now.
    explicit MeasurementFile(const std::string& command);

    void add(const std::string& title, const std::vector<Column>& columns,
             const std::vector<Row>& rows);

    const std::string& text() const { return text_; }

 private:
    std::string text_;
};

}  // namespace aula::bench
