// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SeenText_h
#define isosurface_SeenText_h

#include "vtkNew.h"
#include "vtkOutputWindow.h"
#include "vtkSmartPointer.h"
#include "vtkStringOutputWindow.h"

#include <string>

namespace isosurface
{

/// What a user sees of errors while it lives: the text of VTK's output window.
class SeenText
{
public:
  SeenText()
    : Before(vtkOutputWindow::GetInstance())
  {
    vtkOutputWindow::SetInstance(this->Window);
  }
  ~SeenText() { vtkOutputWindow::SetInstance(this->Before); }
  SeenText(const SeenText&) = delete;
  SeenText& operator=(const SeenText&) = delete;

  std::string Get() { return this->Window->GetOutput(); }

private:
  vtkSmartPointer<vtkOutputWindow> Before;
  vtkNew<vtkStringOutputWindow> Window;
};

} // namespace isosurface

#endif
