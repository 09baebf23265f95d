namespace dapple::measure {}
