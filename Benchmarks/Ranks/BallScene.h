// SPDX-License-Identifier: BSD-3-Clause
#ifndef BallScene_h
#define BallScene_h

#include "vtkSmartPointer.h"

#include <string>

class vtkActor;

/// Balls at random places in a cube of 1, of 1,104 triangles each.
struct BallScene
{
  int Balls = 2000;
  double Radius = 0.02;
  /// How balls are dealt out to ranks: "compact", "random", or in "layers", one behind the other.
  std::string Layout = "compact";
};

/// The balls of a rank, of `ranks` ranks.
vtkSmartPointer<vtkActor> MakeBalls(const BallScene& scene, int rank, int ranks);

#endif
