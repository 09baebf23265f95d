namespace dapple::truth {}
