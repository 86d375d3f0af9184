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
copy gmsh "$fixtures"/meshes/*.msh "$fixtures"/meshes/refused/*.msh
copy medit "$fixtures"/meshes/*.mesh "$fixtures"/meshes/refused/*.mesh*
copy vtu "$fixtures"/simplices/*.vtu
copy vtk "$fixtures"/simplices/*.vtk
copy abaqus "$fixtures"/simplices/*.inp
mkdir -p corpus/tetgen
for nodes in "$fixtures"/meshes/*.node; do
    { cat "$nodes"; printf '\0'; cat "${nodes%.node}.ele"; } > "corpus/tetgen/$(basename "$nodes")"
done
for folder in "$fixtures"/fuzz/*/; do
    [ -d "$folder" ] && copy "$(basename "$folder")" "$folder"/*
done
