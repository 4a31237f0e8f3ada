// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TableFile_h
#define isosurface_TableFile_h

#include <fstream>
#include <string>

namespace isosurface
{

/// Writes tables of Core/Coding/TrainedModels as its MakeTables.cmake reads them: a line with name, type
/// and count, then the numbers.
class TableFile
{
public:
  /// program: the one that writes, for the comment at the head of the file.
  TableFile(const std::string& path, const std::string& program)
    : File(path)
  {
    this->File << "# SPDX-License-Identifier: BSD-3-Clause\n"
                  "# Tables of Documentation/formats/edge-index.md: name, type, count; then the "
                  "numbers.\n# Written by "
               << program << ".\n";
  }

  /// type: int8, uint16 and so on, as TrainedTables.h declares the table.
  template <typename Numbers>
  void Add(const std::string& name, const std::string& type, const Numbers& numbers)
  {
    this->File << "\n" << name << " " << type << " " << numbers.size() << "\n";
    std::string line;
    for (const auto number : numbers)
    {
      const std::string text = std::to_string(number);
      if (line.size() + 1 + text.size() > 99)
      {
        this->File << line << "\n";
        line.clear();
      }
      line += (line.empty() ? "" : " ") + text;
    }
    this->File << line << "\n";
  }

  bool IsGood() const { return this->File.good(); }

private:
  std::ofstream File;
};

} // namespace isosurface

#endif
