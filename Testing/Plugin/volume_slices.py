# SPDX-License-Identifier: BSD-3-Clause
"""What GuiSlice.xml showed was coarse at first, and what it saved right after a change is the exact slice."""
from paraview import servermanager, simple

import plugin_testing as testing


class SavedSlice(testing.TestCase):
    def test_nothing_was_wrong_when_coarse_slices_took_the_place_of_exact_ones(self):
        errors = [line for line in testing.read_window_log().splitlines() if "ERR|" in line]
        self.assertEqual(errors, [])

    def test_slices_were_coarse_first(self):
        self.assertGreaterEqual(testing.read_window_log().count("VolumeSlice1: level 2 was shown until"), 2)

    def test_saved_slice_is_exact(self):
        saved = simple.XMLImageDataReader(FileName=[testing.state("saved.vti")])
        saved.UpdatePipeline()
        self.assertEqual(saved.GetDataInformation().GetExtent(), (0, 600, 0, 600, 0, 0))
        exact = simple.VolumeSlice(Input=testing.open_volume("slab.bvol"), Origin=[300, 300, 5])
        samples = [
            testing.read_samples(servermanager.Fetch(source)) for source in (saved, exact)
        ]
        self.assertTrue((samples[0] == samples[1]).all())
        self.assertEqual(saved.GetDataInformation().GetBounds()[4:], (5, 5))


testing.run()
