#include <matio.h>

#include <cmath>
#include <cstdint>
#include <memory>

#include "base/error.hpp"
#include "diagnose/recording/data_table.hpp"

namespace bayesctrl {

DataTable read_mat(const std::filesystem::path& path) {
  const std::unique_ptr<mat_t, decltype(&Mat_Close)> mat(Mat_Open(path.c_str(), MAT_ACC_RDONLY), &Mat_Close);
  if (mat == nullptr) throw DataError({path.string()}, "not a MATLAB file, or it cannot be read");
  DataTable table;
  const auto add = [&](const std::string& name, const matvar_t* variable) {
    if (variable == nullptr || variable->rank != 2 || variable->data == nullptr || variable->isComplex) return;
    if (variable->class_type < MAT_C_DOUBLE || variable->class_type > MAT_C_UINT64) return;  // no plain numbers
    const std::size_t rows = variable->dims[0], columns = variable->dims[1];
    const bool vector = rows == 1 || columns == 1;
    const auto number = [&](std::size_t i) -> double {
      switch (variable->data_type) {
        case MAT_T_DOUBLE:
          return static_cast<const double*>(variable->data)[i];
        case MAT_T_SINGLE:
          return static_cast<double>(static_cast<const float*>(variable->data)[i]);
        case MAT_T_INT32:
          return static_cast<const std::int32_t*>(variable->data)[i];
        case MAT_T_INT16:
          return static_cast<const std::int16_t*>(variable->data)[i];
        case MAT_T_UINT16:
          return static_cast<const std::uint16_t*>(variable->data)[i];
        case MAT_T_UINT32:
          return static_cast<const std::uint32_t*>(variable->data)[i];
        case MAT_T_INT8:
          return static_cast<const std::int8_t*>(variable->data)[i];
        case MAT_T_UINT8:
          return static_cast<const std::uint8_t*>(variable->data)[i];
        case MAT_T_INT64:
          return static_cast<double>(static_cast<const std::int64_t*>(variable->data)[i]);
        case MAT_T_UINT64:
          return static_cast<double>(static_cast<const std::uint64_t*>(variable->data)[i]);
        default:
          return std::nan("");
      }
    };
    const std::size_t length = vector ? rows * columns : rows;
    for (std::size_t c = 0; c < (vector ? 1 : columns); ++c) {
      std::vector<double> values;
      for (std::size_t i = 0; i < length; ++i) values.push_back(number(c * length + i));
      table.names.push_back(vector ? name : name + "(" + std::to_string(c + 1) + ")");
      table.columns.push_back(std::move(values));
    }
  };
  while (true) {
    const std::unique_ptr<matvar_t, decltype(&Mat_VarFree)> variable(Mat_VarReadNext(mat.get()), &Mat_VarFree);
    if (variable == nullptr) break;
    if (variable->class_type == MAT_C_STRUCT) {
      if (variable->data == nullptr || variable->rank != 2 || variable->dims[0] * variable->dims[1] == 0) continue;
      char* const* fields = Mat_VarGetStructFieldnames(variable.get());
      for (unsigned i = 0; i < Mat_VarGetNumberOfFields(variable.get()); ++i) {
        add(std::string(variable->name) + "." + fields[i], Mat_VarGetStructFieldByIndex(variable.get(), i, 0));
      }
    } else {
      add(variable->name, variable.get());
    }
  }
  if (table.names.empty()) throw DataError({path.string()}, "the file holds no real vectors");
  return table;
}

}  // namespace bayesctrl
