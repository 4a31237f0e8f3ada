// SPDX-License-Identifier: BSD-3-Clause
/** What views need while ParaView's window loads a state. */

#ifndef StateLoading_h
#define StateLoading_h

class pqView;

namespace isosurface
{

/// Whether a state is being loaded, on any server. Until it is there, the plugin draws nothing.
bool IsStateLoading();

/**
 * Has a view that a state makes drawn as a whole until the state is there. A window that has been
 * resized is drawn as while the camera moves, with thinned surfaces beyond the LOD threshold. If that
 * is the first image, what has no thinned form was never delivered, and a ruler ends the window
 * (vtkRulerSourceRepresentation of ParaView 5.11 and 6.1).
 */
void DrawWholeUntilLoaded(pqView* view);

} // namespace isosurface

#endif
