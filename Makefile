# Two commands do all the set-up on Debian or Ubuntu with a Rust toolchain: `make demo` and `make test`.

.PHONY: demo test package deps test-deps

# A toolchain installed a minute ago is not yet in the PATH of this shell.
export PATH := $(PATH):$(HOME)/.cargo/bin

# Installs missing system packages, builds, runs the demonstration and says where its maps are.
demo: deps
	cargo build --release --locked
	./target/release/floodsim run scenarios/demo/scenario.yaml --out runs/demo --overwrite
	./target/release/floodsim report runs/demo
	@echo
	@echo "The maps of the demonstration:"
	@echo "  one page with everything   runs/demo/report/index.html"
	@echo "  for QGIS, with styles      runs/demo/cog/*.tif and runs/demo/results.gpkg"
	@echo "  grids as CF NetCDF         runs/demo/maps.nc and runs/demo/fields.nc"

# Installs what the tests need beyond that, too, and passes all tests.
test: test-deps
	FLOODSIM_REQUIRE_READERS=1 cargo test --release --locked

# What others install without a toolchain: an archive and a package for this release of Debian or Ubuntu, in dist/.
package: deps
	./scripts/package.sh

deps:
	@./scripts/deps.sh

test-deps:
	@./scripts/deps.sh test
	@if [ -x scripts/readers.sh ]; then ./scripts/readers.sh; fi
