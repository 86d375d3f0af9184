#!/bin/sh
# Copies the test fixtures into the corpus of the target that reads them.
set -eu
cd "$(dirname "$0")"
fixtures=../crates/grosgrain/tests/fixtures
copy() {
    target=$1
    shift
    mkdir -p "corpus/$target"
    for file in "$@"; do
        cp "$file" "corpus/$target/$(basename "$(dirname "$file")")-$(basename "$file")"
    done
}
copy nifti "$fixtures"/volumes/*.nii "$fixtures"/volumes/*.nii.gz
copy nrrd "$fixtures"/volumes/*.nrrd
copy metaimage "$fixtures"/volumes/*.mha
copy tiff "$fixtures"/volumes/*.tif "$fixtures"/volumes/tiff_folder/*.tif
copy npy "$fixtures"/volumes/*.npy
copy dicom "$fixtures"/volumes/dicom_*/*.dcm
for folder in "$fixtures"/fuzz/*/; do
    [ -d "$folder" ] && copy "$(basename "$folder")" "$folder"/*
done
